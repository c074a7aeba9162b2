"""Random three-tank windows solved by the default search, and judged."""

import functools
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from benchmarks.judge import FINER, SAME_OPTIMUM, Judge, values_of
from benchmarks.runner import cpu_seconds, monte_carlo, progress, timed
from benchmarks.tanks import PARAMETERS, STATES, TankWindow, blank_record, random_window
from obs_ros import Estimate, solve_window
from obs_ros.core.typing import Array
from obs_ros.integration.backends import kernels_for
from obs_ros.integration.grid import Grid
from obs_ros.models.three_tank import THREE_TANK

UNKNOWNS = STATES + PARAMETERS
SOLVED = 4.0 * SAME_OPTIMUM  # of sigma^2: as strict as for four unknowns
KNOWLEDGE = ('unknown', 'known')  # what the search is told of the noise
FULL_WINDOW = 1000  # samples
YARDSTICK_LANES = 32
_GATES = np.array([FULL_WINDOW])
INTERIOR = 3.0  # standard deviations from every bound of the box


class Verdict(NamedTuple):
    """Excess of the sum of squares over the optimum, in sigma^2, and error over Cramér-Rao bound.

    `ratios` (d,) are the errors over the bounds on their standard deviations.
    """

    excess: Mapping[str, float]
    ratios: Mapping[str, Array]
    interior: bool
    crossing: bool


class Solved(NamedTuple):
    """One call of `solve_window`, its process time, that without process noise and the yardstick's.

    All in s.
    """

    estimate: Estimate
    seconds: float
    plain: float
    yardstick: float


def warm_up(samples: int) -> None:
    """Compile, and touch all that a first solve touches."""
    solve(random_window(0, samples, 20.0), 'unknown', seed=0)


def solve_all(seeds: Sequence[int], samples: int, snr_db: float) -> Mapping[str, Sequence[Solved]]:
    """Solve every window in this process, one after the other, with and without the noise known."""
    solved: dict[str, list[Solved]] = {known: [] for known in KNOWLEDGE}
    for seed in progress(seeds, f'solve, {snr_db:g} dB', len(seeds)):
        window = random_window(seed, samples, snr_db)
        for known in KNOWLEDGE:
            solved[known].append(solve(window, known, seed))
    return solved


def solve(window: TankWindow, known: str, seed: int) -> Solved:
    """Time one solve."""
    noise = dict.fromkeys(('h1', 'h2'), window.sigma) if known == 'known' else None
    call = functools.partial(solve_window, 'three_tank', window.record, seed=seed, noise=noise)
    plain = cpu_seconds(functools.partial(call, process_noise='off'))
    return Solved(*timed(call), plain, cpu_seconds(yardstick))


def yardstick() -> None:
    """Do some fixed work: even process time differs by half as the machine is loaded."""
    points = np.linspace(0.3, 0.9, 3 * YARDSTICK_LANES).reshape(3, -1)
    kernels_for(THREE_TANK).squares(_yardstick_grid(), _GATES, 100.0 * points, points)


@functools.cache
def _yardstick_grid() -> Grid:
    return Grid.of(THREE_TANK, blank_record(np.arange(float(FULL_WINDOW))), np.ones(2))


def judge_all(
    solved: Mapping[str, Sequence[Solved]],
    seeds: Sequence[int],
    samples: int,
    snr_db: float,
    starts: int,
) -> list[Verdict]:
    """Judge every window on all cores."""
    tasks = []
    for i, seed in enumerate(seeds):
        found = {known: values_of(own[i].estimate) for known, own in solved.items()}
        tasks.append((seed, samples, snr_db, starts, found))
    return monte_carlo(judged, {snr_db: tasks}, f'judge, {snr_db:g} dB')[snr_db]


def judged(
    seed: int, samples: int, snr_db: float, starts: int, found: Mapping[str, Mapping[str, float]]
) -> Verdict:
    """Find the optimum of one window independently, and compare the values found of it.

    `found` are values by name, by what the search was told of the noise.
    """
    window = random_window(seed, samples, snr_db)
    judge = Judge(THREE_TANK, window.record, UNKNOWNS, {}, finer=FINER)
    best = judge.optimum(window.truth, starts, seed)
    sd = np.sqrt(np.diag(judge.bound(window.truth, window.sigma)))
    truth = np.array([window.truth[name] for name in UNKNOWNS])
    room = np.minimum(truth - judge.lower, judge.lower + judge.width - truth)
    error = {
        known: np.array([values[name] for name in UNKNOWNS]) - truth
        for known, values in found.items()
    }
    return Verdict(
        excess={k: (judge.squares(v) - best) / window.sigma**2 for k, v in found.items()},
        ratios={k: e / sd for k, e in error.items()},
        interior=bool((room > INTERIOR * sd).all()),
        crossing=window.crossing,
    )
