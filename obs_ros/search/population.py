"""First populations in the unit box: chaotic maps, and plain random ones to compare them with.

Yang, Li & Dahhou 2020 (section 4.1) start from the cubic map. Measured on their windows, no map
makes a difference against uniform or Latin hypercube starts.
"""

from collections.abc import Callable

import numpy as np
from scipy.stats import qmc

from obs_ros.registry import suggest
from obs_ros.typing import Array


def cubic(z: Array) -> Array:
    """z <- 4 z^3 - 3 z on [-1, 1], here moved to [0, 1]; fixed points 0, 1/2, 1."""
    w = 2.0 * z - 1.0
    return 0.5 * (4.0 * w**3 - 3.0 * w) + 0.5


def logistic(z: Array) -> Array:
    """z <- 4 z (1 - z)."""
    return 4.0 * z * (1.0 - z)


def tent(z: Array) -> Array:
    """Tent with its top at 0.7: the symmetric one runs into zero in binary arithmetic."""
    return np.where(z < 0.7, z / 0.7, (1.0 - z) / 0.3)


def sine(z: Array) -> Array:
    """z <- sin(pi z)."""
    return np.sin(np.pi * z)


MAPS: dict[str, Callable[[Array], Array]] = {
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
        return np.asarray(qmc.LatinHypercube(dimension, rng=rng).random(size))
    points = np.empty((size, dimension))
    # Seeds off the fixed points 0, 1/2 and 1, from which the maps never leave.
    z = rng.uniform(0.01, 0.49, dimension)
    for i in range(size):
        z = np.clip(MAPS[kind](z), 0.0, 1.0)
        points[i] = z
    if even and kind in ('cubic', 'logistic'):
        return 0.5 + np.arcsin(2.0 * points - 1.0) / np.pi
    return points


def check_population(kind: str) -> None:
    """Raise ValueError unless there is such a kind of population."""
    if kind not in POPULATIONS:
        raise ValueError(f'unknown chaotic map {kind!r}: {suggest(kind, POPULATIONS)}')
