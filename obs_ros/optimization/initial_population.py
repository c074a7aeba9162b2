"""First populations in the unit box: chaotic maps, and plain random ones to compare them with.

Yang, Li & Dahhou 2020 (section 4.1) start from the cubic map. Measured on their windows, no map
makes a difference against uniform or Latin hypercube starts.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from obs_ros.core.deadline import Deadline
from obs_ros.core.registry import suggest
from obs_ros.core.typing import Array
from obs_ros.optimization.problem import Problem


@dataclass(frozen=True)
class BlockSettings:
    """Points that are drawn or rolled out between two looks at the clock."""

    points: int = 1024  # no more of them are in memory than that
    share: float = 1.0 / 3.0  # of the time that is left, which drawing points may have taken


BLOCKS = BlockSettings()


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
    kind: str,
    size: int,
    dimension: int,
    rng: np.random.Generator,
    *,
    even: bool = False,
    deadline: Deadline | None = None,
) -> Array:
    """Return `size` points (size, d) of the unit box.

    A map runs along every dimension from a random seed. The cubic and the logistic map visit the
    ends of the interval more often; `even` undoes that. With a `deadline`, drawing ends after a
    quarter of the time, with one block of points at least. Raises ValueError for an unknown kind.
    """
    check_population(kind)
    parts: list[Array] = []
    for points in _blocks(kind, size, dimension, rng):
        parts.append(points)
        if deadline is not None and deadline.elapsed > BLOCKS.share * deadline.remaining:
            break
    points = parts[0] if len(parts) == 1 else np.concatenate(parts)
    if even and kind in ('cubic', 'logistic'):
        return 0.5 + np.arcsin(2.0 * points - 1.0) / np.pi
    return points


def costs_in_time(
    problem: Problem, z: Array, deadline: Deadline, nodes: int | None = None
) -> Array:
    """Return the costs (B,) of points z (B, d), rolled out block by block.

    Infinite from where the deadline passes; the first block is always rolled out.
    """
    costs = np.full(len(z), np.inf)
    for first in range(0, len(z), BLOCKS.points):
        if first and deadline.passed:
            break
        part = slice(first, first + BLOCKS.points)
        costs[part] = problem.costs(z[part], nodes)
    return costs


def _blocks(kind: str, size: int, dimension: int, rng: np.random.Generator) -> Iterator[Array]:
    """Yield the points in blocks (B, d); Latin hypercubes are one for each block."""
    sizes = [min(BLOCKS.points, size - first) for first in range(0, size, BLOCKS.points)]
    if kind == 'uniform':
        yield from (rng.random((block, dimension)) for block in sizes)
    elif kind == 'latin_hypercube':
        from scipy.stats import qmc  # takes long to import, and is hardly ever wanted

        sampler = qmc.LatinHypercube(dimension, seed=rng)
        yield from (np.asarray(sampler.random(block)) for block in sizes)
    else:
        # Seeds off the fixed points 0, 1/2 and 1, from which the maps never leave.
        last = rng.uniform(0.01, 0.49, dimension).tolist()
        for block in sizes:
            orbits = [_orbit(MAPS[kind], z, block) for z in last]
            last = [orbit[-1] for orbit in orbits]
            yield np.array(orbits).T


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
