"""Whether what a window leaves unexplained looks like noise."""

from dataclasses import dataclass

import numpy as np
from scipy.special import chdtr, chdtri

from obs_ros.core.typing import Array

TAIL = 0.001
WHITE_LIMIT = 2.81  # standard deviations of the lag-1 correlation
MOST_CORRELATION = 0.99
LONG_TAIL = 2.0  # times what the lag-1 correlation foretells; chance does not sum to that


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


def inflation(correlation: float) -> float:
    """Return by how much noise of this lag-1 correlation raises variances of what it disturbs.

    As autoregressive noise of first order does what changes more slowly; 1 for a negative one.
    """
    r = min(max(correlation, 0.0), MOST_CORRELATION)
    return (1.0 + r) / (1.0 - r)


def independent_share(correlation: float) -> float:
    """Return how many independent squares, for each one, vary as much in sum (Bartlett)."""
    r = min(max(correlation, 0.0), MOST_CORRELATION)
    return (1.0 - r**2) / (1.0 + r**2)


def inflation_by(residuals: Array, known: float = 0.0) -> float:
    """Return by how much correlated residuals raise the variance of what is estimated from them.

    One plus twice the sum of their correlations (K, r; NaN = not measured) up to the first that is
    lost in the noise, but not less than autoregressive noise of the same lag-1 correlation r has,
    (1 + r) / (1 - r). That is against noise whose lag-1 correlation is `known`; 1 where r may well
    be that of such noise and the sum is not far above what that foretells.
    """
    worst = 1.0
    for column in residuals.T:
        r = column[np.isfinite(column)]
        square = float(r @ r)
        if r.size < 3 or square == 0.0:
            continue
        spectrum = np.abs(np.fft.rfft(r, 2 * r.size)) ** 2
        correlations = np.fft.irfft(spectrum)[: r.size] / square
        chance = WHITE_LIMIT / np.sqrt(r.size)
        lost = np.flatnonzero(correlations[1:] < chance)
        upto = 1 + (int(lost[0]) if lost.size else r.size - 1)
        summed = 1.0 + 2.0 * float(correlations[1:upto].sum())
        as_known = correlations[1] - known < chance * np.sqrt(1.0 - known**2)
        if as_known and summed <= LONG_TAIL * inflation(known):
            continue
        worst = max(worst, max(summed, inflation(float(correlations[1]))) / inflation(known))
    return worst


def is_white(residuals: Array) -> bool:
    """Whether the lag-1 correlation of residuals (K, r; NaN = not measured) is that of noise."""
    return whiteness(residuals).white


def like_noise(squares: float, freedom: float) -> bool:
    """Whether residuals of unit variance may well sum to these squares, by chi-square."""
    return squares <= float(chdtri(max(1.0, freedom), TAIL))


def too_small(squares: float, freedom: float) -> bool:
    """Whether residuals of unit variance would hardly ever sum to so little, by chi-square."""
    return bool(squares < freedom) and float(chdtr(max(1.0, freedom), squares)) < TAIL
