"""Runs of observers of the heat exchanger's flows, and the figures measured in them."""

import functools
import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from benchmarks.play import Contestant, columns, played
from benchmarks.report import rms
from benchmarks.runner import monte_carlo
from obs_ros import Sample, load_observer
from obs_ros.core.typing import Array
from obs_ros.models import heat_exchanger as plant
from plant_sim.scenarios import load_scenario
from plant_sim.scenarios.heat_exchanger import NOISE
from plant_sim.signals import Noise

BAND = 0.02  # of a flow: settled within
FAULTS = (80.0, 150.0)  # s, of case 2: first Fu's valve, then Fp's
SETTLING = 4.0  # s after a fault that do not count as plateau
NAMING = 2.0  # s after a fault by which its valve must be known


# Whoever estimates the flows of this plant can be added here.
CONTESTANTS = (
    Contestant('interconnected, theta 80', 'interconnected', {'theta': 80.0}),
    Contestant('interconnected, theta 2', 'interconnected', {'theta': 2.0}),
    Contestant('high gain, theta 5', 'high_gain', {'theta': 5.0}),
    Contestant('high gain, theta 2', 'high_gain', {'theta': 2.0}),
    Contestant('unknown input', 'unknown_input', {'tau': (0.55, 0.19)}),
)
PAPERS_START = {'start_flow': 0.0, 'initial': {'Tp': 30.0, 'Tu': 30.0}}


class Case(NamedTuple):
    """A part of a scenario, from `begin` to `end` (s)."""

    scenario: str
    begin: float
    end: float


CASES = {
    1: Case('heat_exchanger_case1', 0.0, 12.0),
    2: Case('heat_exchanger_case2', 70.0, 180.0),
    3: Case('heat_exchanger_case3', 0.0, 40.0),
}


class Found(NamedTuple):
    """Times (K,), estimated and true flows and residuals (K, 2): Fp and Fu."""

    t: Array
    flows: Array
    truth: Array
    residuals: Array


class Measured(NamedTuple):
    """Figures of a run, for Fp and Fu: s, %, and whether the faulty valve was named."""

    settled: Array
    rms: Array
    named: tuple[bool, ...]
    most: float  # largest flow, of nominal
    finite: bool


Runs = Mapping[tuple[str, int], list[Measured]]  # by contestant and case, over the seeds


def runs_of(seeds: Sequence[int]) -> tuple[Runs, Runs]:
    """Return the runs without noise (cases 1, 2) and those with (cases 2, 3)."""

    def cells(cases: Sequence[int], seeds: Sequence[int | None]) -> dict[tuple[str, int], Any]:
        return {
            (one.label, case): [(one, case, seed) for seed in seeds]
            for case in cases
            for one in CONTESTANTS
        }

    quiet = monte_carlo(measured, cells((1, 2), (None,)), 'without noise')
    return quiet, monte_carlo(measured, cells((2, 3), seeds), 'with noise')


@functools.cache
def truth_of(case: int) -> tuple[Array, Array, Array, Array]:
    """Times (K,), inputs, temperatures without noise and true flows (K, 2) of a case."""
    name, begin, end = CASES[case]
    period = load_scenario(name).sample_period
    rows = played(name, round(end / period) + 1, snr_db=math.inf)[round(begin / period) :]
    flows = [[plant.flow2(i.p[1], i.x[4]), plant.flow1(i.p[0], i.x[2])] for i in rows]
    t, u, y = columns(rows, 'tuy')
    return t, u, y, np.array(flows)


def observed(one: Contestant, case: int, seed: int | None) -> Found:
    """Let an observer watch a case; the seed is that of the noise, None for none."""
    t, u, y, truth = truth_of(case)
    if seed is not None:
        noise = Noise(seed, 2, math.exp(-(t[1] - t[0]) / 0.1))
        y = y + np.array([noise.draw(NOISE) for _ in t])
    settings = {**one.settings, **(PAPERS_START if case == 1 else {})}
    observer: Any = load_observer(one.observer)('heat_exchanger', **settings)
    flows, residuals = np.empty_like(truth), np.empty_like(truth)
    for k, stamp in enumerate(np.round(t * 1e9).astype(np.int64).tolist()):
        observer.absorb(Sample(stamp, y=y[k], u=u[k]))
        flows[k] = observer.flows
        residuals[k] = observer.figures['residual_Fp'], observer.figures['residual_Fu']
    return Found(t, flows, truth, residuals)


def measured(one: Contestant, case: int, seed: int | None) -> Measured:
    """Let an observer watch a case, and measure."""
    run = observed(one, case, seed)
    t, error = run.t, run.flows / run.truth - 1.0
    if case == 1:
        since, plateau = (0.0, 0.0), t > 8.0
    elif case == 2:
        since = FAULTS[::-1]
        after = [(t >= fault) & (t < fault + SETTLING) for fault in (CASES[2].begin, *FAULTS)]
        plateau = ~np.any(after, axis=0)
    else:
        since, plateau = (0.0, 0.0), t > 10.0
    # Fu has settled, or not, when Fp's valve fails.
    until = (CASES[case].end, FAULTS[1] if case == 2 else CASES[case].end)
    settled = [settling(t, error[:, i], since[i], until[i]) for i in range(2)]
    nominal = np.array([flow.nominal for flow in plant.HEAT_EXCHANGER.flows])
    return Measured(
        np.array(settled),
        100.0 * rms(error[plateau], 0),
        named_valves(run) if case == 2 else (),
        float((run.flows / nominal).max()),
        bool(np.isfinite(run.flows).all() and np.isfinite(run.residuals).all()),
    )


def settling(t: Array, error: Array, begin: float, end: float) -> float:
    """Return how long after `begin` the error last was out of the band, until `end` (s)."""
    out = (t >= begin) & (t < end) & (np.abs(error) > BAND)
    return float(t[np.flatnonzero(out)[-1]] - begin) if out.any() else 0.0


def named_valves(run: Found) -> tuple[bool, ...]:
    """Tell for each fault if its valve's residual has changed most, in the second up to NAMING."""
    right = []
    for fault, faulty in zip(FAULTS, (1, 0), strict=True):
        before = run.residuals[(run.t >= fault - 2.0) & (run.t < fault)].mean(axis=0)
        span = (run.t >= fault + NAMING - 1.0) & (run.t < fault + NAMING)
        change = np.abs(run.residuals[span].mean(axis=0) - before)
        right.append(bool(change.argmax() == faulty))
    return tuple(right)
