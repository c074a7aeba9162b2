"""Tests of a window's residuals: whether they look like noise, and what it costs if not."""

from dataclasses import dataclass

import numpy as np
from scipy.special import chdtr, chdtri, fdtri

from obs_ros.core.typing import Array


@dataclass(frozen=True)
class ResidualTestSettings:
    """Limits within which residuals pass for noise."""

    tail: float = 0.001  # probability that sums of squares of noise itself lie beyond
    white: float = 2.81  # deviations of the lag-1 correlation; noise exceeds them in 0.5 % of cases
    most_correlation: float = 0.99  # taken of a lag-1 correlation: at 1, inflation is infinite
    blocks: tuple[int, ...] = (8, 32)  # of a window, whose means tell what changes slowly
    slow: float = 0.01  # probability that blocks of noise vary more than those
    long_tail: float = 2.0  # times what lag 1 foretells of all lags; chance does not sum to that


LIMITS = ResidualTestSettings()


@dataclass(frozen=True)
class Whiteness:
    """Lag-1 correlation of residuals, in itself and in standard deviations of that of noise."""

    correlation: float
    deviations: float

    @property
    def white(self) -> bool:
        """Whether noise may well be correlated so much."""
        return abs(self.deviations) < LIMITS.white


def whiteness(residuals: Array) -> Whiteness:
    """Return the lag-1 correlation of residuals (K, r; NaN = not measured) over all outputs."""
    product, square, count = 0.0, 0.0, 0
    for column in residuals.T:
        r = column[np.isfinite(column)]
        product += float(r[1:] @ r[:-1])
        square += float(r @ r)
        count += r.size
    correlation = product / square if square else 0.0
    return Whiteness(correlation, correlation * float(np.sqrt(count)))


def inflation(correlation: float) -> float:
    """Return the factor by which noise of this lag-1 correlation r raises variances.

    It is (1 + r) / (1 - r), as of autoregressive noise of first order on whatever changes more
    slowly; 1 for a negative r.
    """
    r = min(max(correlation, 0.0), LIMITS.most_correlation)
    return (1.0 + r) / (1.0 - r)


def independent_share(correlation: float) -> float:
    """Return the number of independent squares that vary as much as one correlated one (Bartlett).

    It is (1 - r^2) / (1 + r^2) for the lag-1 correlation r.
    """
    r = min(max(correlation, 0.0), LIMITS.most_correlation)
    return (1.0 - r**2) / (1.0 + r**2)


def inflation_by(residuals: Array, known: float = 0.0) -> float:
    """Return the factor by which correlated residuals raise variances of estimates from them.

    It is one plus twice the sum of the correlations of residuals (K, r; NaN = not measured) up to
    the first that is lost in the noise, but not less than `inflation` of their lag-1 correlation r.
    The factor is against noise whose lag-1 correlation is `known`: 1 where r may well be that of
    such noise and the sum is not far above what that foretells.
    """
    worst = 1.0
    for column in residuals.T:
        r = column[np.isfinite(column)]
        square = float(r @ r)
        if r.size < 3 or square == 0.0:
            continue
        spectrum = np.abs(np.fft.rfft(r, 2 * r.size)) ** 2
        correlations = np.fft.irfft(spectrum)[: r.size] / square
        chance = LIMITS.white / np.sqrt(r.size)
        lost = np.flatnonzero(correlations[1:] < chance)
        upto = 1 + (int(lost[0]) if lost.size else r.size - 1)
        summed = 1.0 + 2.0 * float(correlations[1:upto].sum())
        as_known = correlations[1] - known < chance * np.sqrt(1.0 - known**2)
        if as_known and summed <= LIMITS.long_tail * inflation(known):
            continue
        worst = max(worst, max(summed, inflation(float(correlations[1]))) / inflation(known))
    return worst


def is_white(residuals: Array) -> bool:
    """Whether the lag-1 correlation of residuals (K, r; NaN = not measured) is that of noise."""
    return whiteness(residuals).white


def changes_slowly(residuals: Array) -> bool:
    """Whether means over blocks of residuals (K, r; NaN = not measured) vary more than noise's.

    That shows slow changes below the noise, of which neighbours tell little: the sum of squared
    means, in their deviations, is chi-square for noise.
    """
    for blocks in LIMITS.blocks:
        total, freedom = 0.0, 0
        for column in residuals.T:
            r = column[np.isfinite(column)]
            length = r.size // blocks
            square = float(r @ r)
            if length < 2 or square == 0.0:
                continue
            means = r[: length * blocks].reshape(blocks, length).mean(axis=1)
            total += float(means @ means) * length * r.size / square
            freedom += blocks
        if freedom and total > float(chdtri(freedom, LIMITS.slow)):
            return True
    return False


def like_noise(squares: float, freedom: float, told: float = np.inf) -> bool:
    """Whether residuals of unit variance may well sum to these squares, by chi-square.

    Where only so many values `told` that variance, the ratio of both is one of Fisher's F.
    """
    freedom = max(1.0, freedom)
    if np.isfinite(told):
        return squares <= freedom * float(fdtri(freedom, max(1.0, told), 1.0 - LIMITS.tail))
    return squares <= float(chdtri(freedom, LIMITS.tail))


def too_small(squares: float, freedom: float) -> bool:
    """Whether residuals of unit variance would hardly ever sum to so little, by chi-square."""
    return bool(squares < freedom) and float(chdtr(max(1.0, freedom), squares)) < LIMITS.tail
