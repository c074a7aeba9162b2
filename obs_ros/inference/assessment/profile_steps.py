"""The small linear algebra of profiles, for a batch of their ends.

Loops, compiled where Numba is: on matrices of a few rows, calls of NumPy would take longer than
the rollouts. The cost around a point is the quadratic model of squares s, J'r = g and J'J = H: that
of a step is s + 2 g' step + step' H step.
"""

import functools
from dataclasses import dataclass
from typing import Self

import numpy as np

from obs_ros.core.jit import accelerated
from obs_ros.core.typing import AnyArray, Array, BoolArray
from obs_ros.optimization import lm_linalg
from obs_ros.optimization.lm_linalg import solved


@dataclass
class Places:
    """One point (L, d) for each lane, with its squares (L,), J'r (L, d) and J'J (L, d, d)."""

    points: Array
    squares: Array
    gradient: Array
    hessian: Array

    @classmethod
    def repeated(cls, z: Array, squares: Array, gradient: Array, hessian: Array, n: int) -> Self:
        """Return the same point z (1, d) for n lanes."""
        return cls(*(np.repeat(each, n, axis=0) for each in (z, squares, gradient, hessian)))

    def put(self, lanes: AnyArray, other: 'Places', rows: AnyArray) -> None:
        """Take some rows of others as the points of some lanes."""
        self.points[lanes], self.squares[lanes] = other.points[rows], other.squares[rows]
        self.gradient[lanes], self.hessian[lanes] = other.gradient[rows], other.hessian[rows]


@functools.cache
def prepare() -> None:
    """Compile all steps of searches and profiles: at the first solve it would cost its deadline."""
    lm_linalg.prepare()
    a, one, limits = np.ones(1), np.ones((1, 1)), np.ones((2, 1))
    free, pinned = np.zeros(1, dtype=np.bool_), np.zeros(1, dtype=np.int64)
    down = to_optimum(a, a, one, 0.0, -1, 0.0, limits, free)
    change(a, one, down)
    profile_steps(one, a, one, one[None], pinned, a, a, a, 0.0, 1.0, 0.5, limits)


@accelerated
def profile_steps(
    z: Array,
    squares: Array,
    gradient: Array,
    hessian: Array,
    pinned: AnyArray,
    side: Array,
    radius: Array,
    damping: Array,
    least: float,
    growth: float,
    wait: float,
    limits: Array,
) -> tuple[Array, Array, Array]:
    """Return steps (P, d), what the others may still gain (P,), and the cost foretold (P,).

    From points z (P, d) with squares (P,), J'r (P, d) and J'J (P, d, d). Unknown `pinned` (P,)
    moves to the `side` (P,) on which the profile has grown by `growth` above the `least`, the
    others to their optimum inside the limits (2, d), with a `damping` (P,) of steps in boxes. No
    unknown follows the pinned one by more than the `radius` (P,); that one waits as long as a share
    `wait` of the growth is to gain.
    """
    count, d = z.shape
    step = np.zeros((count, d))
    excess, foretold = np.zeros(count), np.zeros(count)
    free = np.zeros(d, dtype=np.bool_)
    for s in range(count):
        k, g, curve = pinned[s], gradient[s], hessian[s]
        down = to_optimum(z[s], g, curve, damping[s], k, 0.0, limits, free)
        excess[s] = -change(g, curve, down)
        lean = solved(curve, np.ones(d), damping[s], curve[k], free)
        curvature, slope = curve[k, k], g[k]
        for i in range(d):
            slope += curve[k, i] * down[i]
            if free[i]:
                curvature -= curve[k, i] * lean[i]
        gap = squares[s] - excess[s] - least - growth
        root = slope * slope - curvature * gap
        move = side[s]
        if curvature > 0.0 and root > 0.0:
            move = (-slope + side[s] * np.sqrt(root)) / curvature
        elif curvature > 0.0 and gap > 0.0:  # the floor is above the level everywhere near
            move = -slope / curvature
        move = min(max(move, -radius[s]), radius[s])
        move = min(max(z[s, k] + move, limits[0, k]), limits[1, k]) - z[s, k]
        share = 0.0
        along = down
        if excess[s] < wait * growth:
            along = to_optimum(z[s], g, curve, damping[s], k, move, limits, free) - down
            farthest = radius[s]
            for i in range(d):  # np.max would have Numba import SciPy's linear algebra
                farthest = max(farthest, abs(along[i]))
            share = radius[s] / farthest
        for i in range(d):
            aim = z[s, i] + down[i] + share * along[i]
            step[s, i] = min(max(aim, limits[0, i]), limits[1, i]) - z[s, i]
        foretold[s] = squares[s] + change(g, curve, step[s])
    return step, excess, foretold


@accelerated
def to_optimum(
    z: Array, gradient: Array, hessian: Array, damping: float, pinned: int, move: float,
    limits: Array, free: BoolArray,
) -> Array:  # fmt: skip
    """Return the step (d,) of least cost in which one unknown makes this move, inside the limits.

    With -1 none is `pinned`. Those that would leave the limits (2, d) stop there; `free` (d,)
    becomes those that do not.
    """
    d = z.size
    step, scale = np.zeros(d), np.ones(d)
    if pinned >= 0:
        step[pinned] = move
    for i in range(d):
        outward = (z[i] <= limits[0, i] and gradient[i] > 0.0) or (
            z[i] >= limits[1, i] and gradient[i] < 0.0
        )
        free[i] = i != pinned and not outward
    for _ in range(d):
        right = np.zeros(d)
        for i in range(d):
            right[i] = -gradient[i]
            for j in range(d):
                if not free[j]:
                    right[i] -= hessian[i, j] * step[j]
        found = solved(hessian, scale, damping, right, free)
        inside = True
        for i in range(d):
            if not free[i]:
                continue
            step[i] = found[i]
            aim = min(max(z[i] + found[i], limits[0, i]), limits[1, i])
            if aim != z[i] + found[i]:
                step[i] = aim - z[i]
                free[i] = inside = False
        if inside:
            break
    return step


@accelerated
def change(gradient: Array, hessian: Array, step: Array) -> float:
    """Return by how much a step (d,) changes the cost, by the quadratic model."""
    total = 0.0
    for i in range(step.size):
        pull = 2.0 * gradient[i]
        for j in range(step.size):
            pull += hessian[i, j] * step[j]
        total += pull * step[i]
    return total
