"""Intervals that were published, held against the truth; errors and deviations in boxes."""

import numpy as np

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


def confidently_wrong(error: Array | float, sd: Array | float) -> BoolArray:
    """Tell where an error is beyond its interval though a standard deviation was given."""
    return np.asarray((np.abs(error) > np.maximum(CONFIDENT * sd, SMALL)) & np.isfinite(sd))
