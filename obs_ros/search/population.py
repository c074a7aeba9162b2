"""First populations in the unit box: chaotic maps, and plain random ones to compare them with.

Yang, Li & Dahhou 2020 (section 4.1) start from the cubic map. Measured on their windows, no map
makes a difference against uniform or Latin hypercube starts.
"""

import math
from collections.abc import Callable

import numpy as np

from obs_ros.registry import suggest
from obs_ros.typing import Array


def cubic(z: float) -> float:
    """w <- 4 w^3 - 3 w on [-1, 1], here moved to [0, 1]; fixed points 0, 1/2, 1."""
    w = 2.0 * z - 1.0
    return 0.5 * (4.0 * w * w * w - 3.0 * w) + 0.5


def logistic(z: float) -> float:
    """z <- 4 z (1 - z)."""
    return 4.0 * z * (1.0 - z)


def tent(z: float) -> float:
    """Tent with its top at 0.7: the symmetric one runs into zero in binary arithmetic."""
    return z / 0.7 if z < 0.7 else (1.0 - z) / 0.3


def sine(z: float) -> float:
    """z <- sin(pi z)."""
    return math.sin(math.pi * z)


MAPS: dict[str, Callable[[float], float]] = {
    'cubic': cubic,
    'logistic': logistic,
    'tent': tent,
    'sine': sine,
}
POPULATIONS = (*MAPS, 'uniform', 'latin_hypercube')


def first_population(
    kind: str, size: int, dimension: int, rng: np.random.Generator, *, even: bool = False
) -> Array:
    """Return `size` points (size, d) of the unit box.

    A map runs along every dimension from a random seed. The cubic and the logistic map visit the
    ends of the interval more often; `even` undoes that. Raises ValueError for an unknown kind.
    """
    check_population(kind)
    if kind == 'uniform':
        return rng.random((size, dimension))
    if kind == 'latin_hypercube':
        from scipy.stats import qmc  # takes long to import, and is hardly ever wanted

        return np.asarray(qmc.LatinHypercube(dimension, seed=rng).random(size))
    # Seeds off the fixed points 0, 1/2 and 1, from which the maps never leave.
    seeds = rng.uniform(0.01, 0.49, dimension)
    points = np.array([_orbit(MAPS[kind], seed, size) for seed in seeds.tolist()]).T
    if even and kind in ('cubic', 'logistic'):
        return 0.5 + np.arcsin(2.0 * points - 1.0) / np.pi
    return points


def _orbit(step: Callable[[float], float], z: float, length: int) -> list[float]:
    """Return the next points of a map. On plain floats: arrays this small only cost overhead."""
    points = []
    for _ in range(length):
        z = min(max(step(z), 0.0), 1.0)  # rounding may leave the interval, and then for good
        points.append(z)
    return points


def check_population(kind: str) -> None:
    """Raise ValueError unless there is such a kind of population."""
    if kind not in POPULATIONS:
        raise ValueError(f'unknown chaotic map {kind!r}: {suggest(kind, POPULATIONS)}')
