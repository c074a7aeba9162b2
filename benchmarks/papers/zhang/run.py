"""Runs of observers of the heat exchanger's flows, and the figures measured in them."""

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from benchmarks.papers.seeds import few, seeds_of
from benchmarks.papers.zhang.plants import (
    CALM,
    CASES,
    COLD,
    FAULTS,
    MOVING,
    NOISE_TIME,
    PROCESS,
    SETTLED,
    UTILITY,
    Case,
    truth_of,
)
from benchmarks.papers.zhang.printed import printed_observer
from benchmarks.papers.zhang.valves import Valves, valves
from benchmarks.papers.zhang.windows import Windows, windows_of
from benchmarks.play import Contestant
from benchmarks.report import rms
from benchmarks.runner import monte_carlo
from obs_ros import Sample, load_observer
from obs_ros.core.typing import Array
from obs_ros.models import heat_exchanger as plant
from plant_sim.scenarios.heat_exchanger import NOISE, NOMINAL
from plant_sim.signals import Noise

BAND = 0.02  # of a flow: settled within
NAMING = 2.0  # s after a fault by which its valve must be known
THETAS = (2.0, 5.0, 20.0, 80.0)
SLOW_NOISE = 1.0  # s, its correlation time
# k1 = k3 and k2 = k4 of section 4.3.1, and factors; l1 = k1 c, l2 = k2 c, c of the utility valve.
PULLS = (0.0, 1.0, 1e4)
K1, K2 = 100.0, 0.15
C_PROCESS, C_UTILITY = map(float, plant.flow_gain(NOMINAL))

# Whoever estimates the flows of this plant can be added here.
PAPER = Contestant('interconnected, theta 80', 'interconnected', {'theta': 80.0})
OURS = Contestant('interconnected, theta 2', 'interconnected', {'theta': 2.0})
UNKNOWN = Contestant('unknown input', 'unknown_input', {'tau': (0.55, 0.19)})
CONTESTANTS = (
    PAPER,
    OURS,
    Contestant('high gain, theta 5', 'high_gain', {'theta': 5.0}),
    Contestant('high gain, theta 2', 'high_gain', {'theta': 2.0}),
    UNKNOWN,
)
RATED = (PAPER, OURS, UNKNOWN)  # of these rates are told, of the others medians
PAPERS_START = {'start_flow': 0.0, 'initial': {'Tp': 30.0, 'Tu': 30.0}}


class Found(NamedTuple):
    """Times (K,), estimated and true flows and residuals (K, 2): Fp and Fu; temperatures (K, 2)."""

    t: Array
    flows: Array
    truth: Array
    residuals: Array
    off: Array  # K, of the estimated temperatures


class Measured(NamedTuple):
    """Figures of a run, for Fp and Fu: settling (s), RMS (%), and whether a faulty valve was named.

    `warm` is the time (s) from which on both temperatures are within 0.1 K.
    """

    settled: Array
    rms: Array
    named: bool
    most: float  # largest flow, of nominal
    finite: bool
    warm: float


Runs = Mapping[tuple[str, str], list[Measured]]  # by contestant and case, over the seeds


class Figures(NamedTuple):
    """All that was measured, of so many seeds for each rate.

    `quiet` has no noise, `noisy` has 0.05 K of it over 0.1 s and `slow` over 1 s; `starts` begin
    anywhere; `tuned` is the settling of case 1 by theta, `pulled` that by the factor of k1 to k4;
    `printed` is that of eq. 48 to the letter; `valves` are the states of the valves with the
    printed k1 to k4.
    """

    seeds: int
    quiet: Runs
    noisy: Runs
    slow: Runs
    starts: list[Measured]
    tuned: Mapping[float, Array]
    pulled: Mapping[float, Array]
    printed: Array
    valves: Valves
    windows: Windows
    first: int  # seed of the pictures


def measure(seeds: int) -> Figures:
    """Watch all cases, without noise and with."""
    quiet = monte_carlo(
        measured,
        {(one.label, case.label): [(one, case, None)] for case in CASES for one in CONTESTANTS},
        'without noise',
    )
    noisy = monte_carlo(measured, noisy_cells(seeds), 'with noise')
    slow = monte_carlo(
        measured,
        {
            (one.label, CALM.label): [
                (one, CALM, seed, SLOW_NOISE)
                for seed in seeds_of('zhang', 'slow noise', few(seeds))
            ]
            for one in RATED
        },
        'slow noise',
    )
    starts = monte_carlo(
        from_anywhere, {'': [(seed,) for seed in seeds_of('zhang', 'starts', seeds)]}, 'starts'
    )['']
    tuned = {
        theta: measured(PAPER._replace(settings={'theta': theta}), COLD, None).settled
        for theta in THETAS
    }
    pulled = {
        factor: measured(PAPER._replace(settings=pulls(factor)), COLD, None).settled
        for factor in PULLS
    }
    windows = windows_of(seeds)
    first = seeds_of('zhang', UTILITY.label, 1)[0]
    return Figures(
        seeds, quiet, noisy, slow, starts, tuned, pulled, settled_as_printed(),
        valves(PAPER._replace(settings=pulls(1.0))), windows, first,
    )  # fmt: skip


def noisy_cells(seeds: int) -> dict[tuple[str, str], list[tuple[Any, ...]]]:
    """Return the runs with noise; contestants begin with the same seeds, to be compared."""
    return {
        (one.label, case.label): [
            (one, case, seed)
            for seed in seeds_of(
                'zhang', case.label,
                seeds if one in RATED and case in FAULTS else few(seeds),
            )
        ]
        for case in (*FAULTS, MOVING)
        for one in CONTESTANTS
    }  # fmt: skip


def pulls(factor: float) -> dict[str, float]:
    """Return the paper's settings with k1 to k4 times a factor."""
    return {'theta': 80.0, 'l1': factor * K1 * C_UTILITY, 'l2': factor * K2 * C_UTILITY}


def settled_as_printed() -> Array:
    """Return when the flows of eq. 48 to the letter settle in case 1 (s), inf for never."""
    t, _, y, truth = truth_of(COLD)
    flows = printed_observer(y, float(t[1] - t[0]))
    error = flows / truth - 1.0
    return np.array([settling(t, error[:, i], 0.0, COLD.end) for i in range(2)])


def observed(
    one: Contestant, case: Case, seed: int | None, correlation: float = NOISE_TIME
) -> Found:
    """Let an observer watch a case; the seed is that of the noise, None for none."""
    t, u, y, truth = truth_of(case)
    if seed is not None:
        noise = Noise(seed, 2, math.exp(-(t[1] - t[0]) / correlation))
        measured_y = y + np.array([noise.draw(NOISE) for _ in t])
    else:
        measured_y = y
    settings = {**(PAPERS_START if case == COLD else {}), **one.settings}
    observer: Any = load_observer(one.observer)('heat_exchanger', **settings)
    flows, residuals, warm = np.empty_like(truth), np.empty_like(truth), np.empty_like(truth)
    for k, stamp in enumerate(np.round(t * 1e9).astype(np.int64).tolist()):
        observer.absorb(Sample(stamp, y=measured_y[k], u=u[k]))
        flows[k], warm[k] = observer.flows, observer.x[:2]
        residuals[k] = observer.figures['residual_Fp'], observer.figures['residual_Fu']
    return Found(t, flows, truth, residuals, warm - y)


def measured(
    one: Contestant, case: Case, seed: int | None, correlation: float = NOISE_TIME
) -> Measured:
    """Let an observer watch a case, and measure."""
    run = observed(one, case, seed, correlation)
    error, plateau = run.flows / run.truth - 1.0, run.t >= case.counted
    nominal = np.array([flow.nominal for flow in plant.HEAT_EXCHANGER.flows])
    cold = np.flatnonzero((np.abs(run.off) > 0.1).any(axis=1))
    return Measured(
        np.array([settling(run.t, error[:, i], case.fault, case.end) for i in range(2)]),
        100.0 * rms(error[plateau], 0),
        names_valve(run, case),
        float((run.flows / nominal).max()),
        bool(np.isfinite(run.flows).all() and np.isfinite(run.residuals).all()),
        float(run.t[cold[-1]]) if cold.size else 0.0,
    )


def from_anywhere(seed: int) -> Measured:
    """Let the paper's observer start case 1 from random temperatures and flows, without noise."""
    rng = np.random.default_rng(seed)
    tp, tu = rng.uniform(plant.TUI, plant.TPI, 2)
    start = {'start_flow': float(rng.uniform(0.0, 5.0)), 'initial': {'Tp': tp, 'Tu': tu}}
    one = PAPER._replace(settings={**PAPER.settings, **start})
    return measured(one, COLD._replace(end=SETTLED, counted=SETTLED - 1.0), None)


def settling(t: Array, error: Array, begin: float, end: float) -> float:
    """Return how long after `begin` the error last was out of the band; inf where to the `end`.

    What is not a number is out of it.
    """
    inside = np.flatnonzero((t >= begin) & (t < end))
    out = inside[~(np.abs(error[inside]) <= BAND)]
    if not out.size:
        return 0.0
    return math.inf if out[-1] == inside[-1] else float(t[out[-1]] - begin)


def names_valve(run: Found, case: Case) -> bool:
    """Tell if the faulty valve's residual has changed most, in the second up to NAMING."""
    if case not in FAULTS:
        return False
    before = run.residuals[(run.t >= case.fault - 2.0) & (run.t < case.fault)].mean(axis=0)
    span = (run.t >= case.fault + NAMING - 1.0) & (run.t < case.fault + NAMING)
    change = np.abs(run.residuals[span].mean(axis=0) - before)
    return bool(change.argmax() == (0 if case == PROCESS else 1))
