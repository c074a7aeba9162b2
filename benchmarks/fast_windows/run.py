"""Windows of three tanks in sequence and alone, timed in turn with C rollouts; and with a tree."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from benchmarks.c_twin import SNR, YARDSTICK, c_step
from benchmarks.pairs import Cost, Pair, in_turns
from benchmarks.runner import progress, timed
from benchmarks.tanks import TRUE_STEP, noise_of, random_window
from obs_ros import Estimate, Record, solve_window
from obs_ros.core.deadline import Deadline
from obs_ros.core.rng import random_generator
from obs_ros.core.typing import Array
from obs_ros.horizon.moving_horizon import MovingHorizon
from obs_ros.horizon.solver import Solver
from obs_ros.integration.backends import kernels_for
from obs_ros.integration.grid import Grid
from obs_ros.models.three_tank import THREE_TANK

PERIOD = 50  # s between the ends of windows in sequence
HOLD = 100  # s that an inflow stays
JUMPING = 300  # samples of the windows with a jump inside
REPEATS = 3  # of windows beside another tree, of which the least time counts
SETTLED = 2  # windows of a sequence, the first ones, that are not counted
# Windows by themselves beside another tree: samples, dB.
ALONE = {'cold 50, 20 dB': (50, 20.0), 'cold 1000, 40 dB': (1000, 40.0)}


class Window(NamedTuple):
    """A window solved: process time (s), candidate-steps, C's time for one (s), its outcome."""

    seconds: float
    steps: int
    yardstick: float
    outcome: str

    @property
    def ratio(self) -> float:
        """Time over the limit."""
        return self.seconds / (self.steps * self.yardstick)


class Row(NamedTuple):
    """The windows of one kind."""

    kind: str
    windows: list[Window]


Costs = Mapping[tuple[Any, ...], Sequence[Pair]]  # by kind of window, and more


def rows_of(seeds: Sequence[int], windows: int) -> list[Row]:
    """Measure windows of every kind; those without and with a jump in turn."""
    yardstick = c_step()
    rows: dict[str, list[Window]] = {}
    for seed in progress(seeds, 'windows', len(seeds)):
        for samples in (300, 1000):
            found = in_sequence(records(seed, samples, windows), yardstick)
            rows.setdefault(f'warm {samples}', []).extend(found[SETTLED:])
        first, last = 2 * SETTLED, 2 * SETTLED + JUMPING // PERIOD - 1  # that see the jump
        jumping = records(seed, JUMPING, windows, jump=True)
        found = in_sequence(jumping, yardstick)
        rows.setdefault(f'warm {JUMPING}, a jump inside', []).extend(found[first:last])
        for i in range(windows):
            alone = partial(solved_alone, YARDSTICK, SNR, windows * seed + i)
            rows.setdefault(f'cold {YARDSTICK}', []).append(measured(alone, yardstick))
    return [Row(kind, found) for kind, found in rows.items()]


def measured(solve: Callable[[], Estimate], yardstick: Callable[[], float]) -> Window:
    """Time a window, between two measurements of the yardstick."""
    before = yardstick()
    estimate, seconds = timed(solve)
    steps = estimate.evaluations * (estimate.times.size - 1)
    return Window(seconds, steps, 0.5 * (before + yardstick()), str(estimate.outcome.value))


def in_sequence(windows: Sequence[Record], yardstick: Callable[[], float]) -> list[Window]:
    """Solve windows in sequence, as the node does."""
    horizon = sequence()
    return [
        measured(partial(horizon.solve, record, random_generator(0, i), Deadline(None)), yardstick)
        for i, record in enumerate(windows)
    ]


def sequence() -> MovingHorizon:
    """Return a sequence of tanks' windows, all compiled."""
    solver = Solver.of(THREE_TANK)
    solver.prepare()
    return MovingHorizon(solver)


def solved_alone(samples: int, snr: float, seed: int) -> Estimate:
    """Solve a random window by itself."""
    return solve_window(THREE_TANK, random_window(seed, samples, snr).record, seed=seed)


def records(seed: int, samples: int, windows: int, *, jump: bool = False) -> list[Record]:
    """Draw windows in sequence; a valve may jump where the window after the settled ones ends."""
    rng = np.random.default_rng([seed, samples])
    count = samples + (windows - 1) * PERIOD
    t = np.arange(float(count))
    u = np.repeat(rng.uniform(5.0, 40.0, (count // HOLD + 1, 2)), HOLD, axis=0)[:count]
    p, x0 = rng.uniform(0.4, 0.95, 3), rng.uniform(20.0, 60.0, 3)
    place = int(rng.integers(3))
    size = -0.2 if p[place] > 0.65 else 0.2  # to where the model allows it
    at = samples + (2 * SETTLED - 1) * PERIOD - PERIOD // 2 if jump else count - 1
    after = p.copy()
    after[place] += size
    y: Array = simulated(t, u, x0, p, after, at)[:, :2] + noise_of(SNR) * rng.standard_normal(
        (count, 2)
    )
    parts = [slice(i * PERIOD, i * PERIOD + samples) for i in range(windows)]
    return [Record(t[part], u[part], y[part]) for part in parts]


def simulated(t: Array, u: Array, x0: Array, p: Array, after: Array, at: int) -> Array:
    """Return the true levels (K, 3) in cm; valves p (3,) go over to `after` (3,) at a node."""
    model = replace(THREE_TANK, max_step=TRUE_STEP)
    kernels = kernels_for(model)
    grid = Grid.of(model, Record(t, u, np.zeros((t.size, 2))), np.ones(2))
    before, _ = kernels.trajectories(grid.stretch(0, at), x0[:, None], p[:, None])
    rest = grid.stretch(at, t.size - 1)
    later, _ = kernels.trajectories(rest, np.ascontiguousarray(before[-1]), after[:, None])
    return np.concatenate([before[:, :, 0], later[1:, :, 0]])


def beside(other: Path, seeds: Sequence[int], windows: int) -> Costs:
    """Time windows with this tree and with another one, in turns; those in sequence by sequence."""
    alone = range(windows * seeds[0], windows * (seeds[-1] + 1))
    return {
        **in_turns(other, spent, [(kind,) for kind in ALONE], alone),
        **in_turns(other, spent_warm, [(f'warm {n}', n, windows) for n in (300, 1000)], seeds),
    }


def spent(kind: str, seed: int) -> Cost:
    """Solve a window by itself, the least of three times."""
    runs = [timed(partial(solved_alone, *ALONE[kind], seed)) for _ in range(REPEATS)]
    estimate, seconds = min(runs, key=lambda run: run[1])
    values = tuple(value.hex() for value in estimate.parameters.values())
    return Cost(seconds, values, str(estimate.outcome.value))


def spent_warm(kind: str, samples: int, windows: int, seed: int) -> Cost:
    """Solve windows in sequence, the least of three times of each."""
    drawn = records(seed, samples, windows)
    runs = [in_sequence(drawn, lambda: np.nan)[SETTLED:] for _ in range(REPEATS)]
    seconds = sum(min(w.seconds for w in each) for each in zip(*runs, strict=True))
    return Cost(seconds, (), kind)
