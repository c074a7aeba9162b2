"""Tests by chi-square. SciPy's functions, which take long to import, are asked in close cases."""

import functools
import math
from statistics import NormalDist

# Probabilities for which the formula below was compared with SciPy, from 1 to 1e8 degrees of
# freedom f: its error was at most .76 sqrt(2 / f).
RARE, MARGIN = 1e-4, 1.0


def exceeds(squares: float, freedom: float, tail: float) -> bool:
    """Whether squares of unit variance sum to more than noise does with probability `tail`.

    They are of `freedom` degrees of freedom, at least 1. The limit is that of Wilson & Hilferty
    (1931), eq. 10, or in its neighbourhood, or for probabilities below 1e-4, the exact one.
    """
    if RARE <= tail <= 1.0 - RARE:
        about = _about(freedom, tail)
        if abs(squares - about) > MARGIN * math.sqrt(2.0 / freedom):
            return squares > about
    return squares > _exactly(freedom, tail)


@functools.lru_cache(maxsize=256)
def _about(freedom: float, tail: float) -> float:
    part = 2.0 / (9.0 * freedom)
    return freedom * (1.0 - part + NormalDist().inv_cdf(1.0 - tail) * math.sqrt(part)) ** 3


@functools.lru_cache(maxsize=256)
def _exactly(freedom: float, tail: float) -> float:
    from scipy.special import chdtri

    return float(chdtri(freedom, tail))
