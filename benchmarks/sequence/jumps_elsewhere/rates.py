"""Shares with intervals that know that the windows of one run hang together."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from benchmarks.intervals import share_interval
from obs_ros.core.typing import Array

RESAMPLED = 2000  # times
ENDS = (0.025, 0.975)


class Rate(NamedTuple):
    """A share of hits with its 95 % interval; NaN of nothing."""

    value: float
    low: float
    high: float
    hits: int
    count: int

    def __str__(self) -> str:
        if not self.count:
            return '-'
        digits = 3 if self.value >= 0.02 else 4
        low, value, high = (f'{x:.{digits}f}' for x in (self.low, self.value, self.high))
        return f'{value} ({low}-{high})'


def clustered(pairs: Sequence[tuple[float, float]]) -> Rate:
    """Return the share of hits, from hits and counts of every run.

    The interval is Clopper & Pearson's of as many draws as would spread as the runs do (Kish 1965:
    the design effect), never of more than there are.
    """
    hits, counts = np.array(pairs, dtype=float).reshape(-1, 2).T
    total = float(counts.sum())
    if not total:
        return Rate(np.nan, np.nan, np.nan, 0, 0)
    value, runs = float(hits.sum()) / total, np.count_nonzero(counts)
    effect = 1.0
    if 0.0 < value < 1.0 and runs > 1:
        # Of a ratio of sums, to first order.
        variance = np.sum((hits - value * counts) ** 2) * runs / (runs - 1.0) / total**2
        effect = max(1.0, float(variance) / (value * (1.0 - value) / total))
    draws = total / effect
    return Rate(value, *share_interval(value * draws, draws), round(hits.sum()), round(total))


def resampled(
    statistic: Callable[[Sequence[int]], float], runs: int, seed: int = 0
) -> tuple[float, float, float]:
    """Return a statistic of runs, by their places, with its bootstrap interval over runs."""
    rng = np.random.default_rng(seed)
    drawn = [statistic(rng.integers(runs, size=runs).tolist()) for _ in range(RESAMPLED)]
    low, high = np.nanquantile(drawn, ENDS)
    return statistic(range(runs)), float(low), float(high)


def stacked(parts: Sequence[Array], places: Sequence[int]) -> Array:
    """Return the arrays of these runs as one."""
    return np.concatenate([parts[i] for i in places])
