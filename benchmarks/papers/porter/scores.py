"""Runs of the genetic adaptive observer in numbers: failures, medians, and their intervals."""

import functools
from collections.abc import Iterable, Sequence

import numpy as np

from benchmarks.intervals import (
    difference_interval,
    median_interval,
    ratio_interval,
    share_interval,
)
from benchmarks.papers.claims import Interval, Verdict, every, within
from benchmarks.papers.observed import Outcome, diverged
from benchmarks.papers.porter.plan import BRED, CLAMPED, Outcomes
from obs_ros.observers.papers.gao import GaoSettings

DEFAULT = BRED if GaoSettings().tries else CLAMPED
FAR = 0.5  # of the RMS of x2 itself: an error above it estimates nothing
ALIKE = 0.1  # of shares of failures: how far they may be apart
SIMILAR = 2.0  # of median errors: the same, as a factor
ENDLESS = 1e12  # stands for what is not finite, in medians


def failed(outcome: Outcome) -> bool:
    """True if a run diverged, or its x2 is off by half of what it is itself, RMS."""
    return diverged(outcome) or not outcome.rms[1] <= FAR * outcome.size[1]


def unsettled(outcome: Outcome) -> bool:
    """True if x2 did not stay within 0.05 before the run's end."""
    return diverged(outcome) or not np.isfinite(outcome.settled)


def apart(one: tuple[float, float], other: tuple[float, float]) -> bool:
    """True if two intervals do not overlap."""
    return one[1] < other[0] or other[1] < one[0]


def median(values: Iterable[float]) -> tuple[float, float, float]:
    """Return the median with its 95 % interval; ENDLESS where it is not finite."""
    return _median(tuple(np.nan_to_num([*values], nan=ENDLESS, posinf=ENDLESS).tolist()))


@functools.lru_cache(maxsize=256)  # claims and tables tell the same ones
def _median(values: tuple[float, ...]) -> tuple[float, float, float]:
    return median_interval(values)


def ends(values: Iterable[float]) -> Interval:
    """Return the 95 % interval of the median."""
    return median(values)[1:]


def fail_ends(outcomes: Outcomes, scenario: str, way: str) -> Interval:
    """Return the 95 % interval of the share of runs that fail."""
    return share_interval(*failures(outcomes, scenario, way))


def fail_alike(outcomes: Outcomes, scenario: str, way: str, other: str) -> Verdict:
    """Judge that two observers fail as often: by no more than ALIKE of the runs apart."""
    found = [failures(outcomes, scenario, each) for each in (way, other)]
    return within(difference_interval(*found), (-ALIKE, ALIKE))


def alike(outcomes: Outcomes, scenario: str, way: str, other: str) -> Verdict:
    """Judge that two observers fail as often and have median errors of x2 within SIMILAR."""
    samples = [
        np.nan_to_num(errors(outcomes[scenario, each]), nan=ENDLESS, posinf=ENDLESS)
        for each in (way, other)
    ]
    _, low, high = ratio_interval(*([each] for each in samples))
    errs = within((low, high), (1.0 / SIMILAR, SIMILAR))
    return every([errs, fail_alike(outcomes, scenario, way, other)])


def median_text(values: Iterable[float], unit: str = '') -> str:
    """Return the median of values as text, with its interval if there are several."""
    values = [*values]
    middle, low, high = map(number, median(values))
    return f'{middle}{unit}' if len(values) == 1 else f'{middle}{unit} ({low} to {high})'


def number(value: float) -> str:
    """Return a number with three significant digits, or that there is none."""
    return f'{value:.3g}' if np.isfinite(value) and value < ENDLESS else 'never'


def errors(outcomes: Sequence[Outcome]) -> list[float]:
    """Return the RMS errors of x2 over the second half of each run."""
    return [float(one.rms[1]) for one in outcomes]


def failures(outcomes: Outcomes, scenario: str, way: str) -> tuple[int, int]:
    """Return how many runs failed, and of how many."""
    found = outcomes[scenario, way]
    return sum(map(failed, found)), len(found)


def rms_text(outcomes: Outcomes, scenario: str, way: str) -> str:
    """Return the median RMS error of x2 as text."""
    return median_text(errors(outcomes[scenario, way]))
