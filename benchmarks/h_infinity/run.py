"""Runs of observers of the suspension's tyre stiffness, and the figures measured in them."""

import functools
import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from benchmarks.intervals import confidently_wrong
from benchmarks.play import Contestant, columns, played
from benchmarks.report import rms
from benchmarks.runner import monte_carlo
from obs_ros import Outcome, Sample, load_observer
from obs_ros.core.typing import Array
from obs_ros.models.suspension import KT, SUSPENSION
from obs_ros.observers.sliding_window import SlidingWindowObserver
from plant_sim.scenarios import load_scenario
from plant_sim.scenarios.suspension import BUMPS

FIRST = 24.0  # s, when both bumps are passed: what counts
NEAR = 0.1  # of kt
BEGIN, END = 7.0, 28.0  # s; before and after that the road is straight: nothing is learnt there
LONG = 65.0  # s, end of the specification's runs
BOX = SUSPENSION.parameters[0].upper - SUSPENSION.parameters[0].lower  # N/m


# Whoever estimates kt of this plant can be added here.
CONTESTANTS = (
    Contestant('filtered regressor, designed gains', 'h_infinity', {}),
    Contestant(
        "the paper's: gradient, printed gains", 'h_infinity',
        {'adaptation': 'gradient', 'gains': 'printed'},
    ),
    Contestant('gradient, designed gains', 'h_infinity', {'adaptation': 'gradient'}),
    Contestant('EKF on (x, kt)', 'ekf', {'parameters': ('kt',)}),
    Contestant('EKF on (x, kt, eta)', 'ekf', {}),
    Contestant(
        'windows of 1 s on (x, kt)', 'sliding_window',
        {'duration': 1.0, 'period': 1.0, 'parameters': ('kt',)},
    ),
    Contestant(
        'windows of 1 s on (x, kt, eta)', 'sliding_window', {'duration': 1.0, 'period': 0.5}
    ),
    # As long as a bump and what it leaves behind.
    Contestant(
        'windows of 3 s on (x, kt, eta)', 'sliding_window', {'duration': 3.0, 'period': 0.5}
    ),
)  # fmt: skip
BLIND = CONTESTANTS[5].label


class Case(NamedTuple):
    """A road, the force on the damper (N) that is reached at 12 s, and noise (m)."""

    scenario: str
    force: float
    noise: float

    @property
    def label(self) -> str:
        """Return the case in words."""
        road = self.scenario.removeprefix('suspension_')
        return f'{road}, eta {self.force:g} N, {1e3 * self.noise:g} mm'


CASES = (
    Case('suspension_trap', 0.0, 1e-4),
    Case('suspension_trap', 300.0, 1e-4),
    Case('suspension_trap', 300.0, 1e-3),
    Case('suspension_cos', 0.0, 1e-3),
    Case('suspension_rect', 300.0, 1e-4),
    Case('suspension_kt_step', 300.0, 1e-4),
)


AT_LENGTH = (CASES[1], CASES[3])  # these also to LONG


def contestants(case: Case, end: float = END) -> list[Contestant]:
    """Return all, but for windows blind to eta on roads that add nothing to that."""
    blind = case in CASES[:4] and end == END
    return [one for one in CONTESTANTS if blind or one.label != BLIND]


class Window(NamedTuple):
    """An estimate of kt (N/m) at `time` (s): relative error, sd (N/m; NaN = withheld), outcome."""

    time: float
    error: float
    sd: float
    outcome: Outcome

    @property
    def confidently_wrong(self) -> bool:
        """True if it claims to be surer than it is."""
        return bool(confidently_wrong(self.error * KT / BOX, self.sd / BOX))


class Observed(NamedTuple):
    """Times (K,), estimates and truth of kt (K,), and the windows of a sliding one."""

    t: Array
    found: Array
    kt: Array
    windows: tuple[Window, ...] = ()


class Measured(NamedTuple):
    """RMS (%) of kt from FIRST on, s from the first bump until within NEAR, and finiteness."""

    rms: float
    near: float
    finite: bool
    windows: tuple[Window, ...] = ()


Runs = Mapping[tuple[str, str], list[Measured]]  # by contestant and case, over the seeds


def runs_of(seeds: Sequence[int], long_seeds: Sequence[int]) -> tuple[Runs, Runs]:
    """Return all runs: those to END, and those to LONG."""

    def runs(cases: Sequence[Case], seeds: Sequence[int], end: float) -> Runs:
        cells = {
            (one.label, case.label): [(one, case, seed, end) for seed in seeds]
            for case in cases
            for one in contestants(case, end)
        }
        return monte_carlo(measured, cells, f'runs to {end:g} s')

    return runs(CASES, seeds, END), runs(AT_LENGTH, long_seeds, LONG)


@functools.cache
def truth_of(scenario: str, disturbed: bool) -> tuple[Array, Array, Array, Array]:
    """Times (K,), inputs (K, 2), positions without noise (K, 3) and true kt (K,)."""
    period = load_scenario(scenario).sample_period
    faults = {} if disturbed else {'eta': 0.0}
    rows = played(scenario, round(LONG / period) + 1, faults=faults, snr_db=math.inf)
    t, u, y, p = columns(rows[round(BEGIN / period) :], 'tuyp')
    return t, u, y, p[:, 0]


def observed(one: Contestant, case: Case, seed: int, end: float = END) -> Observed:
    """Let an observer drive over the road to `end` (s); its estimate starts from half of kt."""
    t, u, y, kt = truth_of(case.scenario, case.force > 0.0)
    until = int(np.searchsorted(t, end + 0.5e-3))
    t, u, y, kt = t[:until], u[:until], y[:until], kt[:until]
    y = y + case.noise * np.random.default_rng(seed).standard_normal(y.shape)
    if one.observer == 'sliding_window':
        return observed_in_windows(one, case, t, u, y, kt)
    observer: Any = load_observer(one.observer)(
        'suspension',
        initial={'kt': 0.5 * KT},
        noise=dict.fromkeys(('zs', 'zus', 'zd'), case.noise),
        **one.settings,
    )
    found = np.empty_like(t)
    for k, stamp in enumerate(np.round(t * 1e9).astype(np.int64).tolist()):
        observer.absorb(Sample(stamp, y=y[k], u=u[k]))
        found[k] = observer.p[0]
    return Observed(t, found, kt)


def observed_in_windows(
    one: Contestant, case: Case, t: Array, u: Array, y: Array, kt: Array
) -> Observed:
    """Return the same of a sliding window: each estimate stands until the next."""
    observer = SlidingWindowObserver(
        'suspension', noise=dict.fromkeys(('zs', 'zus', 'zd'), case.noise), **one.settings
    )
    found = np.full_like(t, 0.5 * KT)
    windows = []
    for k, stamp in enumerate(np.round(t * 1e9).astype(np.int64).tolist()):
        if observer.absorb(Sample(stamp, y=y[k], u=u[k])) and (estimate := observer.estimate()):
            found[k:] = estimate.parameters['kt']
            error = estimate.parameters['kt'] / kt[k] - 1.0
            windows.append(Window(float(t[k]), error, estimate.stddev['kt'], estimate.outcome))
    return Observed(t, found, kt, tuple(windows))


def measured(one: Contestant, case: Case, seed: int, end: float) -> Measured:
    """Let an observer drive over the road, and measure."""
    t, found, kt, windows = observed(one, case, seed, end)
    error = found / kt - 1.0
    near = (t >= BUMPS[0]) & (np.abs(error) <= NEAR)
    return Measured(
        float(100.0 * rms(error[t > FIRST])),
        float(t[near.argmax()] - BUMPS[0]) if near.any() else math.inf,
        bool(np.isfinite(found).all()),
        windows,
    )
