"""Tests of a window's residuals: whether they look like noise, and what it costs if not."""

import functools
from dataclasses import dataclass

import numpy as np

from obs_ros.core.chi_square import exceeds
from obs_ros.core.jit import unhurried
from obs_ros.core.typing import Array, IntArray


@dataclass(frozen=True)
class ResidualTestSettings:
    """Limits within which residuals pass for noise."""

    tail: float = 0.001  # probability that sums of squares of noise itself lie beyond
    white: float = 2.81  # deviations of the lag-1 correlation; noise exceeds them in 0.5 % of cases
    most_correlation: float = 0.99  # taken of a lag-1 correlation: at 1, inflation is infinite
    blocks: tuple[int, ...] = (8, 32)  # of a window, whose means tell what changes slowly
    slow: float = 0.01  # probability that blocks of noise vary more than those
    long_tail: float = 2.0  # times what lag 1 foretells of all lags; chance does not sum to that
    lags: int = 32  # correlations that are summed product by product; more, by their spectrum


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


@functools.cache
def prepare() -> None:
    """Compile what is below, or load it compiled."""
    whiteness(np.ones((1, 1)))
    squares_of(np.ones((1, 1)))
    inflation_by(np.ones((3, 1)))
    changes_slowly(np.ones((2 * LIMITS.blocks[0], 1)))


def whiteness(residuals: Array) -> Whiteness:
    """Return the lag-1 correlation of residuals (K, r; NaN = not measured) over all outputs."""
    product, square, count = 0.0, 0.0, 0
    sizes, squares, products = _head(np.ascontiguousarray(residuals), 1, np.inf)
    for i, size in enumerate(sizes.tolist()):
        product += float(products[i, 1])
        square += float(squares[i])
        count += size
    correlation = product / square if square else 0.0
    return Whiteness(correlation, correlation * float(np.sqrt(count)))


def _packed_on_arrays(residuals: Array, i: int, r: Array) -> tuple[int, float]:
    """Do the same on whole arrays."""
    column = residuals[:, i]
    kept = column[np.isfinite(column)]
    r[: kept.size] = kept
    return kept.size, float(np.add.accumulate(kept * kept)[-1]) if kept.size else 0.0


def _packed_looped(residuals: Array, i: int, r: Array) -> tuple[int, float]:
    """Write what was measured of column i of residuals (K, n) to r (K,); return size and square."""
    size, square = 0, 0.0
    for k in range(len(residuals)):
        if np.isfinite(residuals[k, i]):
            r[size] = residuals[k, i]
            square += r[size] * r[size]
            size += 1
    return size, square


_packed = unhurried(_packed_looped, _packed_on_arrays, exact=True)


def _squares_on_arrays(residuals: Array) -> tuple[IntArray, Array]:
    """Return the same on whole arrays."""
    counts = np.isfinite(residuals).sum(axis=0)
    squares = np.where(np.isnan(residuals), 0.0, residuals * residuals)
    return counts, np.add.accumulate(squares)[-1] if len(squares) else np.zeros(counts.size)


def _squares_in_loops(residuals: Array) -> tuple[IntArray, Array]:
    """Return how many of residuals (K, r; NaN = not measured) are finite (r,), and squares (r,)."""
    nodes, outputs = residuals.shape
    counts, squares = np.zeros(outputs, dtype=np.int64), np.zeros(outputs)
    for k in range(nodes):
        for i in range(outputs):
            if not np.isnan(residuals[k, i]):
                squares[i] += residuals[k, i] * residuals[k, i]
                counts[i] += np.isfinite(residuals[k, i])
    return counts, squares


squares_of = unhurried(_squares_in_loops, _squares_on_arrays, exact=True)


def _head_on_arrays(residuals: Array, lags: int, limit: float) -> tuple[IntArray, Array, Array]:
    """Return the same on whole arrays."""
    sizes = np.zeros(residuals.shape[1], dtype=np.int64)
    squares, products = np.zeros(sizes.size), np.full((sizes.size, lags + 1), np.nan)
    for i, column in enumerate(residuals.T):
        r = column[np.isfinite(column)]
        sizes[i], squares[i] = r.size, r @ r
        for lag in range(1, lags + 1):
            products[i, lag] = r[lag:] @ r[:-lag]
            if products[i, lag] * np.sqrt(r.size) < limit * squares[i]:
                break
    return sizes, squares, products


def _head_looped(residuals: Array, lags: int, limit: float) -> tuple[IntArray, Array, Array]:
    """Return the sizes (r,) and squares (r,) of columns of residuals, and products (r, 1 + lags).

    The products are those of residuals so many samples apart, up to the first whose correlation is
    below `limit` deviations of that of noise; NaN beyond.
    """
    nodes, outputs = residuals.shape
    sizes, squares = np.zeros(outputs, dtype=np.int64), np.zeros(outputs)
    products, r = np.full((outputs, lags + 1), np.nan), np.empty(nodes)
    for i in range(outputs):
        size, square = _packed(residuals, i, r)
        sizes[i], squares[i] = size, square
        for lag in range(1, lags + 1):
            product = 0.0
            for k in range(lag, size):
                product += r[k] * r[k - lag]
            products[i, lag] = product
            if product * np.sqrt(size) < limit * square:
                break
    return sizes, squares, products


_head = unhurried(_head_looped, _head_on_arrays)


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
    worst, expected = 1.0, inflation(known)
    residuals = np.ascontiguousarray(residuals)
    sizes, squares, products = _head(residuals, LIMITS.lags, LIMITS.white)
    for i, (size, square) in enumerate(zip(sizes.tolist(), squares.tolist(), strict=True)):
        if size < 3 or square == 0.0:
            continue
        correlations = [product / square for product in products[i, 1:].tolist()]
        chance = LIMITS.white / size**0.5
        first, summed = correlations[0], 0.0
        for correlation in correlations:
            if not correlation >= chance:  # NaN is beyond the first that is lost
                break
            summed += correlation
        else:
            summed = _summed(residuals[:, i], chance)
        summed = 1.0 + 2.0 * summed
        as_known = first - known < chance * (1.0 - known**2) ** 0.5
        if as_known and summed <= LIMITS.long_tail * expected:
            continue
        worst = max(worst, max(summed, inflation(first)) / expected)
    return worst


def _summed(column: Array, chance: float) -> float:
    """Return the sum of the correlations of residuals (K,) up to the first below `chance`."""
    r = column[np.isfinite(column)]
    spectrum = np.abs(np.fft.rfft(r, 2 * r.size)) ** 2
    correlations = np.fft.irfft(spectrum)[1 : r.size] / float(r @ r)
    lost = np.flatnonzero(correlations < chance)
    return float(correlations[: int(lost[0]) if lost.size else r.size].sum())


def is_white(residuals: Array) -> bool:
    """Whether the lag-1 correlation of residuals (K, r; NaN = not measured) is that of noise."""
    return whiteness(residuals).white


def changes_slowly(residuals: Array) -> bool:
    """Whether means over blocks of residuals (K, r; NaN = not measured) vary more than noise's.

    That shows slow changes below the noise, of which neighbours tell little: the sum of squared
    means, in their deviations, is chi-square for noise.
    """
    residuals = np.ascontiguousarray(residuals)
    for blocks in LIMITS.blocks:
        total, freedom = _block_means(residuals, blocks)
        if freedom and exceeds(total, freedom, LIMITS.slow):
            return True
    return False


def _block_means_on_arrays(residuals: Array, blocks: int) -> tuple[float, int]:
    """Return the same on whole arrays."""
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
    return total, freedom


def _block_means_looped(residuals: Array, blocks: int) -> tuple[float, int]:
    """Return the sum of squared means over blocks of residuals, in deviations, and their number."""
    nodes, outputs = residuals.shape
    total, freedom, r = 0.0, 0, np.empty(nodes)
    for i in range(outputs):
        size, square = _packed(residuals, i, r)
        length = size // blocks
        if length < 2 or square == 0.0:
            continue
        sums = 0.0
        for b in range(blocks):
            mean = 0.0
            for k in range(b * length, (b + 1) * length):
                mean += r[k]
            mean /= length
            sums += mean * mean
        total += sums * length * size / square
        freedom += blocks
    return total, freedom


_block_means = unhurried(_block_means_looped, _block_means_on_arrays)


def like_noise(squares: float, freedom: float, told: float = np.inf) -> bool:
    """Whether residuals of unit variance may well sum to these squares, by chi-square.

    Where only so many values `told` that variance, the ratio of both is one of Fisher's F.
    """
    freedom = max(1.0, freedom)
    if np.isfinite(told):
        from scipy.special import fdtri

        return squares <= freedom * float(fdtri(freedom, max(1.0, told), 1.0 - LIMITS.tail))
    return bool(np.isfinite(squares)) and not exceeds(squares, freedom, LIMITS.tail)


def too_small(squares: float, freedom: float) -> bool:
    """Whether residuals of unit variance would hardly ever sum to so little, by chi-square."""
    return bool(squares < freedom) and not exceeds(squares, max(1.0, freedom), 1.0 - LIMITS.tail)
