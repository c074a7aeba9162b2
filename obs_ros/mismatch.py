"""Whether what a window leaves unexplained looks like noise."""

from dataclasses import dataclass

import numpy as np
from scipy.special import chdtr, chdtri

from obs_ros.typing import Array

TAIL = 0.001
WHITE_LIMIT = 2.81  # standard deviations of the lag-1 correlation


@dataclass(frozen=True)
class Whiteness:
    """Lag-1 correlation of residuals, in itself and in standard deviations of that of noise."""

    correlation: float
    deviations: float

    @property
    def white(self) -> bool:
        """Whether noise may well be correlated so much."""
        return abs(self.deviations) < WHITE_LIMIT


def whiteness(residuals: Array) -> Whiteness:
    """Return how the residuals (K, r; NaN = not measured) of one sample foretell the next."""
    product, square, count = 0.0, 0.0, 0
    for column in residuals.T:
        r = column[np.isfinite(column)]
        product += float(r[1:] @ r[:-1])
        square += float(r @ r)
        count += r.size
    correlation = product / square if square else 0.0
    return Whiteness(correlation, correlation * float(np.sqrt(count)))


def is_white(residuals: Array) -> bool:
    """Whether the lag-1 correlation of residuals (K, r; NaN = not measured) is that of noise."""
    return whiteness(residuals).white


def like_noise(squares: float, freedom: int) -> bool:
    """Whether residuals of unit variance may well sum to these squares, by chi-square."""
    return squares <= float(chdtri(max(1, freedom), TAIL))


def too_small(squares: float, freedom: int) -> bool:
    """Whether residuals of unit variance would hardly ever sum to so little, by chi-square."""
    return bool(squares < freedom) and float(chdtr(max(1, freedom), squares)) < TAIL
