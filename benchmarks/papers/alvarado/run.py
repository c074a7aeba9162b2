"""Runs of observers of the suspension's tyre stiffness, and the figures measured in them."""

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from benchmarks.intervals import confidently_wrong
from benchmarks.papers.alvarado.printed import (
    PAPERS_START,
    RIGHT_START,
    Printed,
    printed_observer,
    sign_choices,
)
from benchmarks.papers.alvarado.roads import (
    CASES,
    LONG,
    SOFTENING,
    Case,
    Truth,
    noisy,
    truth_of,
)
from benchmarks.papers.seeds import few, seeds_of
from benchmarks.play import Contestant
from benchmarks.report import rms
from benchmarks.runner import monte_carlo
from obs_ros import Outcome, Sample, load_observer
from obs_ros.core.typing import Array
from obs_ros.models.suspension import KT, SUSPENSION
from obs_ros.observers.papers.adaptive_gains import stored_gains
from obs_ros.observers.sliding_window import SlidingWindowObserver
from plant_sim.scenarios.suspension import BUMPS, RISE

NEAR = 0.1  # of kt
SOON = 1.0  # s after the first bump begins, from when on kt must be near
BOX = SUSPENSION.parameters[0].upper - SUSPENSION.parameters[0].lower  # N/m
SCALE = 1e5  # N/m, in which Gamma = 125 moves kt
NO_GAIN, PRINTED, DESIGNED = 'none, L = 0', 'printed, signs restored', 'designed here'

# Whoever estimates kt of this plant can be added here.
PAPER = Contestant(
    "the paper's: gradient, printed gains", 'h_infinity',
    {'adaptation': 'gradient', 'gains': 'printed'},
)  # fmt: skip
FILTERED = Contestant('filtered regressor, designed gains', 'h_infinity', {})
KALMAN = Contestant('EKF on (x, kt, eta)', 'ekf', {})
WINDOWS = Contestant(
    'windows of 1 s on (x, kt, eta)', 'sliding_window', {'duration': 1.0, 'period': 0.5}
)
# As long as a bump and what it leaves behind.
LONG_WINDOWS = Contestant(
    'windows of 3 s on (x, kt, eta)', 'sliding_window', {'duration': 3.0, 'period': 0.5}
)
CONTESTANTS = (PAPER, FILTERED, KALMAN, WINDOWS, LONG_WINDOWS)
RATED = (PAPER, FILTERED, WINDOWS)  # of these rates are told, of the others medians


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
    """Estimates of kt and eta (K,) over a drive, and the windows of a sliding one."""

    kt: Array
    eta: Array
    windows: tuple[Window, ...] = ()


class Measured(NamedTuple):
    """RMS of kt (%) and eta (N) where it counts, s from the bump until within NEAR, finiteness.

    `kept` tells whether kt is within NEAR from SOON after the first bump begins until the end.
    """

    rms: float
    force: float
    near: float
    kept: bool
    finite: bool
    windows: tuple[Window, ...] = ()


class Figures(NamedTuple):
    """All that was measured, of so many seeds for each rate.

    `known` are RMS and largest errors (2, 3) of x1, x3 and z_def in mm after the force has risen,
    kt known, by gains; `speeds` the RMS errors (2,) of x2 and x4 there in % of their own RMS;
    `found` are the printed observer's runs by scale (N/m) and xhat(0), `calm` the same without the
    force, `signs` the RMS of kt (%) with each stable choice of signs. No noise in these.
    """

    seeds: int
    runs: Mapping[tuple[str, str], list[Measured]]  # by contestant and case, over the seeds
    known: Mapping[str, Array]
    speeds: Mapping[str, Array]
    found: Mapping[tuple[float, float], Printed]
    calm: Mapping[tuple[float, float], Printed]
    signs: Sequence[float]
    first: int  # seed of the pictures

    @property
    def calm_states(self) -> float:
        """The largest error of a state (m, m/s) at the end of the runs without force."""
        return max(float(np.abs(run.x[-1]).max()) for run in self.calm.values())


def measure(seeds: int) -> Figures:
    """Drive over all roads, with noise, and over the paper's without."""
    cells = {
        (one.label, case.label): [(one, case, seed) for seed in seeds_for(one, case, seeds)]
        for case in CASES
        for one in CONTESTANTS
    }
    runs = monte_carlo(measured, cells, 'noisy drives')
    truth = truth_of(CASES[0].scenario, True, 0.0, LONG)
    signs = []
    for one in sign_choices():
        if one.stable:
            run = adapted(truth, one.L, RIGHT_START, SCALE)
            signs.append(percent(run.kt[truth.t > CASES[0].counted] / KT - 1.0))
    first = seeds_for(PAPER, CASES[0], 1)[0]
    known, speeds = errors_with_kt_known(truth)
    calm = truth_of(CASES[0].scenario, False, 0.0, LONG)
    return Figures(seeds, runs, known, speeds, as_printed(truth), as_printed(calm), signs, first)


def adapted(truth: Truth, L: Array, start: float, scale: float) -> Printed:
    """Run the printed observer from half of kt."""
    H = stored_gains(SUSPENSION, 'printed').H[0]
    return printed_observer(truth, L, H, start=start, kt=0.5 * KT, scale=scale)


def as_printed(truth: Truth) -> dict[tuple[float, float], Printed]:
    """Run the printed observer with the printed gains, by unit of theta (N/m) and xhat(0)."""
    L = stored_gains(SUSPENSION, 'printed').L
    return {
        (scale, start): adapted(truth, L, start, scale)
        for scale in (1.0, SCALE)
        for start in (RIGHT_START, PAPERS_START)
    }


def seeds_for(one: Contestant, case: Case, seeds: int) -> list[int]:
    """Return the seeds of a case's noise: all contestants begin with the same, to be compared."""
    rated = one in RATED and case != SOFTENING
    return seeds_of('alvarado', case.label, seeds if rated else few(seeds))


def errors_with_kt_known(truth: Truth) -> tuple[dict[str, Array], dict[str, Array]]:
    """Return errors by gains: those of the positions (2, 3), and of the speeds (2,).

    RMS and largest of x1, x3 and z_def in mm; RMS of x2 and x4 in % of their own.
    """
    L = {
        NO_GAIN: np.zeros((4, 3)),
        PRINTED: stored_gains(SUSPENSION, 'printed').L,
        DESIGNED: stored_gains(SUSPENSION, 'designed').L,
    }
    errors, speeds = {}, {}
    counts = truth.t > RISE[1]
    for name, gain in L.items():
        run = printed_observer(truth, gain, np.zeros(3), start=RIGHT_START, kt=KT, scale=1.0,
                               adapts=False)  # fmt: skip
        off = (run.x - truth.x)[counts]
        positions = 1e3 * np.column_stack([off[:, 0], off[:, 2], off[:, 0] - off[:, 2]])
        errors[name] = np.array([rms(positions, 0), np.abs(positions).max(axis=0)])
        speeds[name] = 100.0 * rms(off[:, 1::2], 0) / rms(truth.x[counts, 1::2], 0)
    return errors, speeds


def percent(error: Array) -> float:
    """Return the RMS in %, infinite for what is not finite."""
    return float(100.0 * rms(error)) if np.isfinite(error).all() else math.inf


def observed(one: Contestant, case: Case, truth: Truth, y: Array, seed: int) -> Observed:
    """Let an observer drive over the road; its estimate starts from half of kt.

    Windows are held against the kt of their last interval: at its end one that jumps has told
    nothing yet. The `seed` is that of their searches.
    """
    noise = dict.fromkeys(('zs', 'zus', 'zd'), case.noise)
    stamps = np.round(truth.t * 1e9).astype(np.int64).tolist()
    kt, eta = np.full_like(truth.t, 0.5 * KT), np.zeros_like(truth.t)
    if one.observer != 'sliding_window':
        observer: Any = load_observer(one.observer)(
            'suspension', initial={'kt': 0.5 * KT}, noise=noise, **one.settings
        )
        for k, stamp in enumerate(stamps):
            observer.absorb(Sample(stamp, y=y[k], u=truth.u[k]))
            kt[k], eta[k] = observer.p
        return Observed(kt, eta)
    windows = []
    sliding = SlidingWindowObserver('suspension', noise=noise, seed=seed, **one.settings)
    for k, stamp in enumerate(stamps):
        if sliding.absorb(Sample(stamp, y=y[k], u=truth.u[k])) and (found := sliding.estimate()):
            # An estimate stands until the next.
            kt[k:], eta[k:] = found.parameters['kt'], found.parameters['eta']
            error = found.parameters['kt'] / truth.kt[k - 1] - 1.0
            windows.append(Window(float(truth.t[k]), error, found.stddev['kt'], found.outcome))
    return Observed(kt, eta, tuple(windows))


def measured(one: Contestant, case: Case, seed: int) -> Measured:
    """Let an observer drive over the road, and measure."""
    truth = truth_of(case.scenario, case.force > 0.0, case.begin, case.end)
    found = observed(one, case, truth, noisy(case, truth, seed), seed)
    error, t = found.kt / truth.kt - 1.0, truth.t
    inside = np.abs(error) <= NEAR
    near = (t >= BUMPS[0]) & inside
    counts = t > case.counted
    return Measured(
        percent(error[counts]),
        float(rms((found.eta - truth.eta)[counts])),
        float(t[near.argmax()] - BUMPS[0]) if near.any() else math.inf,
        bool(inside[t >= BUMPS[0] + SOON].all()),
        bool(np.isfinite(found.kt).all()),
        found.windows,
    )
