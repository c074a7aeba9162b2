"""Intervals that were published, held against the truth; errors in boxes; shares of windows."""

from collections.abc import Sequence

import numpy as np
from scipy.stats import beta

from obs_ros import Estimate
from obs_ros.core.typing import Array, BoolArray

COVERED = 1.96  # standard deviations, 95 %
CONFIDENT = 3.0  # standard deviations, and
SMALL = 0.02  # box: an error above both is confidently wrong
DRAWS = 2000  # of the bootstrap


def published_interval(estimate: Estimate, name: str) -> tuple[float, float]:
    """Return the published 95 % interval of a parameter or end state, NaN where none is given.

    That is of its deviation where the estimate, of another tree, has no intervals.
    """
    published = getattr(estimate, 'interval', {})
    if name in published:
        lower, upper = published[name]
        return (lower, upper) if np.isfinite([lower, upper]).all() else (np.nan, np.nan)
    value = {**estimate.parameters, **estimate.state}[name]
    half = COVERED * estimate.stddev[name]
    return value - half, value + half


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


def difference_interval(one: tuple[int, int], other: tuple[int, int]) -> tuple[float, float]:
    """Return the 95 % interval of the second share less the first, each as hits of a count.

    From the intervals of both (Newcombe 1998, method 10, here with those of Clopper & Pearson).
    """
    shares = [hits / count for hits, count in (one, other)]
    (low, high), (other_low, other_high) = (share_interval(*each) for each in (one, other))
    middle = shares[1] - shares[0]
    return (
        middle - float(np.hypot(shares[1] - other_low, high - shares[0])),
        middle + float(np.hypot(other_high - shares[1], shares[0] - low)),
    )


def clustered_interval(hits: Array, counts: Array) -> tuple[float, float]:
    """Return the 95 % interval of a share, from the hits and counts (R,) of R clusters.

    The values of a cluster, a window or a run, hang together. Their number is reduced by the
    design effect, the variance of the share between clusters over the binomial one, in the interval
    of Wilson 1927; where all or none are hits, to that of the clusters.
    """
    total, clusters = float(np.sum(counts)), int(np.count_nonzero(counts))
    if not total:
        return 0.0, 1.0
    share = float(np.sum(hits)) / total
    binomial = share * (1.0 - share) / total
    if binomial > 0.0 and clusters > 1:
        # Of a ratio of sums, to first order.
        spread = np.sum((hits - share * counts) ** 2) * clusters / (clusters - 1) / total**2
        number = total / max(1.0, float(spread) / binomial)
    else:
        number = float(clusters)
    z2 = COVERED**2 / number
    middle = (share + 0.5 * z2) / (1.0 + z2)
    half = np.sqrt(z2 * share * (1.0 - share) + 0.25 * z2**2) / (1.0 + z2)
    return max(middle - float(half), 0.0), min(middle + float(half), 1.0)


def confidently_wrong(error: Array | float, sd: Array | float) -> BoolArray:
    """Tell where an error is beyond its interval though a standard deviation was given."""
    return np.asarray((np.abs(error) > np.maximum(CONFIDENT * sd, SMALL)) & np.isfinite(sd))


def median_interval(values: Sequence[float], seed: int = 0) -> tuple[float, float, float]:
    """Return the median of values with its 95 % interval (percentile bootstrap)."""
    known = np.array(values)
    drawn = np.random.default_rng(seed).integers(known.size, size=(DRAWS, known.size))
    low, high = np.quantile(np.median(known[drawn], axis=1), (0.025, 0.975))
    return float(np.median(known)), float(low), float(high)


def ratio_interval(
    above: Sequence[Array], below: Sequence[Array], seed: int = 0
) -> tuple[float, float, float]:
    """Return the geometric mean, over pairs of samples, of the ratios of their medians.

    With its 95 % interval (percentile bootstrap, each sample drawn again by itself).
    """
    rng = np.random.default_rng(seed)
    pairs = list(zip(above, below, strict=True))
    middle = np.mean([np.log(np.median(a) / np.median(b)) for a, b in pairs])
    logs = np.zeros(DRAWS)
    for a, b in pairs:
        logs += (_log_medians(a, rng) - _log_medians(b, rng)) / len(pairs)
    low, high = np.exp(np.quantile(logs, (0.025, 0.975)))
    return float(np.exp(middle)), float(low), float(high)


def _log_medians(sample: Array, rng: np.random.Generator) -> Array:
    drawn = sample[rng.integers(sample.size, size=(DRAWS, sample.size))]
    return np.log(np.median(drawn, axis=1))
