"""Runs of the observers of the flows in numbers: medians, intervals, named valves, and as text."""

import numpy as np

from benchmarks.intervals import median_interval
from benchmarks.papers.claims import Interval
from benchmarks.papers.zhang.plants import FAULTS, Case
from benchmarks.papers.zhang.run import Figures, Measured, Runs
from benchmarks.play import Contestant
from benchmarks.report import slashed
from obs_ros.core.typing import Array

ALIKE = 0.2  # share by which a printed change may be off


def named(figures: Figures, one: Contestant) -> tuple[int, int]:
    """Return how many faults are charged to the right valve, and of how many."""
    runs = [run for case in FAULTS for run in figures.noisy[one.label, case.label]]
    return sum(run.named for run in runs), len(runs)


def quiet(figures: Figures, one: Contestant, case: Case) -> Measured:
    """Return the run without noise."""
    return figures.quiet[one.label, case.label][0]


def middle(runs: Runs, one: Contestant, case: Case) -> Array:
    """Return the median RMS of Fp and Fu over the seeds (%)."""
    return np.asarray(np.median([run.rms for run in runs[one.label, case.label]], axis=0))


def middle_ends(runs: Runs, one: Contestant, case: Case) -> list[Interval]:
    """Return the intervals of the median RMS of Fp and of Fu over the seeds (%)."""
    found = np.array([run.rms for run in runs[one.label, case.label]])
    return [median_interval(own.tolist())[1:] for own in found.T]


def alike(change: Array, printed: tuple[float, float]) -> bool:
    """Tell if both changes have the printed sign and size."""
    return bool((np.abs(change - printed) <= ALIKE * np.abs(printed)).all())


def times(settled: Array) -> str:
    """Return settling times in s, or that one never comes."""
    return ' / '.join(f'{one:.2f}' if np.isfinite(one) else 'never' for one in settled)


def signed(values: Array) -> str:
    """Return changes of Tp / Tu with their sign."""
    return slashed(values, '+.2f')


def bracketed(values: Array) -> str:
    """Return a median with its 95 % interval."""
    found, low, high = median_interval(values.tolist())
    return f'{found:.2f} ({low:.2f} to {high:.2f})'
