"""Runs of the genetic adaptive state estimator in numbers: errors, sums of their squares."""

import numpy as np
from scipy.stats import t as student

from benchmarks.papers.claims import Interval
from benchmarks.papers.gremling.kalman import FAR
from benchmarks.papers.gremling.plan import Outcomes
from benchmarks.papers.observed import Outcome, diverged
from benchmarks.report import slashed
from obs_ros.core.typing import Array

LATE = 0.5  # s: R is detected if it passes 0.5 no further from the true time


def squares(outcomes: Outcomes, scenario: str, label: str) -> Array:
    """Return the sums (runs, 2) of squared errors of the hidden states."""
    return np.array([one.squares[1:] for one in outcomes[scenario, label]])


def mean_interval(values: Array, others: int = 0) -> tuple[Array, Array, Array]:
    """Return the means (d,) of values (runs, d) and their 95 % intervals (Student's t).

    With `others`, the interval in which the mean of that many further runs lies.
    """
    count = len(values)
    mean = values.mean(axis=0)
    if count == 1:
        return mean, mean, mean
    share = 1.0 / count + (1.0 / others if others else 0.0)
    half = student.ppf(0.975, count - 1) * values.std(axis=0, ddof=1) * np.sqrt(share)
    return mean, mean - half, mean + half


def intervals(values: Array) -> list[Interval]:
    """Return the interval of each mean of values (runs, d)."""
    _, low, high = mean_interval(values)
    return [*zip(low.tolist(), high.tolist(), strict=True)]


def mean_text(values: Array, form: str = '.0f') -> str:
    """Return means that belong together as text, with their intervals if there are several runs."""
    mean, low, high = mean_interval(values)
    if len(values) == 1:
        return slashed(mean, form)
    return f'{slashed(mean, form)} ({slashed(low, form)} to {slashed(high, form)})'


def largest_text(outcomes: Outcomes, scenario: str, label: str) -> str:
    """Return the largest error of each state over a run: the median, and the largest of any run."""
    largest = np.array([one.largest for one in outcomes[scenario, label]])
    middle = slashed(np.median(largest, axis=0), '.3g')
    return middle if len(largest) == 1 else f'{middle}; {slashed(largest.max(axis=0), ".3g")}'


def unbounded(outcome: Outcome) -> bool:
    """True if an observer of the jet engine started again, or a state left the true one."""
    return outcome.resets > 0 or not bool((outcome.largest <= FAR).all())


def undetected(outcome: Outcome) -> bool:
    """True if the estimated stall cells do not grow when the true ones do."""
    return diverged(outcome) or not abs(outcome.onset) <= LATE
