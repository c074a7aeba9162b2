"""Intervals that were published, held against the truth; errors in boxes; shares of windows."""

import numpy as np
from scipy.stats import beta

from obs_ros.core.typing import Array, BoolArray

COVERED = 1.96  # standard deviations, 95 %
CONFIDENT = 3.0  # standard deviations, and
SMALL = 0.02  # box: an error above both is confidently wrong


def covered(error: Array, sd: Array) -> BoolArray:
    """Tell where the 95 % interval holds the truth; false where the deviation is withheld (NaN)."""
    return np.asarray(np.abs(error) <= COVERED * sd)


def coverage(error: Array, sd: Array) -> float:
    """Return the share of the intervals given that hold the truth; NaN where none is given."""
    given = np.isfinite(sd)
    return float(np.mean(covered(error, sd)[given])) if given.any() else np.nan


def share_interval(hits: int, count: int) -> tuple[float, float]:
    """Return the 95 % interval of a share of which so many were hits (Clopper & Pearson 1934)."""
    low = beta.ppf(0.025, hits, count - hits + 1) if hits else 0.0
    high = beta.ppf(0.975, hits + 1, count - hits) if hits < count else 1.0
    return float(low), float(high)


def confidently_wrong(error: Array | float, sd: Array | float) -> BoolArray:
    """Tell where an error is beyond its interval though a standard deviation was given."""
    return np.asarray((np.abs(error) > np.maximum(CONFIDENT * sd, SMALL)) & np.isfinite(sd))
