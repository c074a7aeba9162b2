"""Figures of solved windows, with intervals: ratios of errors, coverage, shares, ratios of time."""

from collections.abc import Callable, Sequence

import numpy as np

from benchmarks.intervals import clustered_interval, share_interval
from benchmarks.sensors.solved import Solved
from obs_ros.core.typing import Array

DRAWS = 1000  # of the bootstrap

Figure = tuple[float, float, float]  # with its 95 % interval


def worst_ratio(faulty: Sequence[Solved], clean: Sequence[Solved]) -> float:
    """Return the largest error in that of the clean windows, of the parameter that is worst."""
    return float(np.max(_largest(faulty) / _largest(clean)))


def rms_ratio(faulty: Sequence[Solved], clean: Sequence[Solved]) -> Figure:
    """Return the root mean square error in that of the same windows clean, over all parameters."""
    bad, good = (np.array([one.error for one in own]) ** 2 for own in (faulty, clean))

    def ratio(places: Array) -> float:
        return float(np.sqrt(np.mean(bad[places].mean(axis=0) / good[places].mean(axis=0))))

    return resampled(ratio, len(bad))


def efficiency(found: Sequence[Solved], best: Sequence[Solved]) -> Figure:
    """Return the variance of the best estimates in that of those found, over all parameters."""
    ratio, low, high = rms_ratio(found, best)
    return ratio**-2, high**-2, low**-2


def coverage(windows: Sequence[Solved]) -> Figure:
    """Return the share of published intervals that hold the truth; windows are clusters."""
    held = np.array([one.held for one in windows])
    hits, counts = np.nansum(held, axis=1), np.isfinite(held).sum(axis=1)
    share = float(hits.sum() / counts.sum()) if counts.any() else np.nan
    return (share, *clustered_interval(hits, counts))


def accepted(windows: Sequence[Solved]) -> Figure:
    """Return the share of windows with a good outcome and all deviations."""
    hits = sum(one.accepted for one in windows)
    return (hits / len(windows), *share_interval(hits, len(windows)))


def resampled(figure: Callable[[Array], float], count: int, seed: int = 0) -> Figure:
    """Return a figure of all of `count` windows with its interval (percentile bootstrap)."""
    rng = np.random.default_rng(seed)
    drawn = [figure(rng.integers(count, size=count)) for _ in range(DRAWS)]
    low, high = np.quantile(drawn, (0.025, 0.975))
    return figure(np.arange(count)), float(low), float(high)


def median_ratio(own: Sequence[float], other: Sequence[float]) -> Figure:
    """Return the median ratio of times taken in pairs."""
    ratios = np.array(own) / np.array(other)
    return resampled(lambda places: float(np.median(ratios[places])), ratios.size)


def words(figure: Figure, form: str = '.3f') -> str:
    """Return a figure with its interval, as text."""
    value, low, high = (format(part, form) for part in figure)
    return f'{value} ({low}-{high})'


def _largest(windows: Sequence[Solved]) -> Array:
    return np.asarray(np.abs([one.error for one in windows]).max(axis=0))
