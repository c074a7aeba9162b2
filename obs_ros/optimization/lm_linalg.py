"""The small linear algebra of Levenberg-Marquardt, for a batch of starts.

Loops, compiled where Numba is: on matrices of a few rows, calls of NumPy would take longer than
the rollouts.
"""

import functools

import numpy as np

from obs_ros.core.jit import accelerated
from obs_ros.core.typing import AnyArray, Array, BoolArray

TINY_DAMPING = 1e-11  # keeps a singular matrix solvable
TINY = 1e-200  # guards divisions by the scale of an unknown without influence


@functools.cache
def prepare() -> None:
    """Compile what is below, or load it compiled: at the first solve it would cost its deadline."""
    a, one = np.ones(1), np.ones((1, 1))
    damped_steps(one, one, one[None], a, np.ones((2, 1)), 1.0)
    judged(a, a, a, a.copy(), a.copy(), np.ones(1, dtype=np.int64), 1.0)


@accelerated
def solved(hessian: Array, scale: Array, damping: float, right: Array, free: BoolArray) -> Array:
    """Return x (d,) of (hessian + damping * diag scale) x = right over the free unknowns, else 0.

    By Cholesky's method; a pivot lost to rounding is replaced by the least that is possible.
    """
    d = right.size
    root = np.zeros((d, d))
    x = np.zeros(d)
    for i in range(d):
        if not free[i]:
            continue
        for j in range(i + 1):
            if not free[j]:
                continue
            value = hessian[i, j]
            if i == j:
                value += damping * scale[i]
            for k in range(j):
                value -= root[i, k] * root[j, k]
            if i == j:
                root[i, i] = np.sqrt(max(value, TINY_DAMPING * scale[i]))
            else:
                root[i, j] = value / root[j, j]
        value = right[i]
        for k in range(i):
            value -= root[i, k] * x[k]
        x[i] = value / root[i, i]
    for i in range(d - 1, -1, -1):
        if free[i]:
            value = x[i]
            for k in range(i + 1, d):
                value -= root[k, i] * x[k]
            x[i] = value / root[i, i]
    return x


@accelerated
def damped_steps(
    z: Array, gradient: Array, hessian: Array, damping: Array, limits: Array, least_curvature: float
) -> tuple[Array, Array, Array]:
    """Return damped steps (P, d), their predicted gains (P,) and those of undamped steps (P,).

    From points z (P, d) with J'r (P, d), J'J (P, d, d) and damping (P,), between limits (2, d). An
    unknown at its limit that leans outward is frozen; a step is clipped to the limits. No unknown's
    scale is below `least_curvature` times the largest.
    """
    count, d = z.shape
    step = np.zeros((count, d))
    gain, full_gain = np.zeros(count), np.zeros(count)
    scale, downhill, free = np.zeros(d), np.zeros(d), np.zeros(d, dtype=np.bool_)
    for s in range(count):
        most = 0.0
        for i in range(d):
            most = max(most, hessian[s, i, i])
        for i in range(d):
            scale[i] = max(hessian[s, i, i], least_curvature * most) + TINY
            outward = (z[s, i] <= limits[0, i] and gradient[s, i] > 0.0) or (
                z[s, i] >= limits[1, i] and gradient[s, i] < 0.0
            )
            free[i], downhill[i] = not outward, -gradient[s, i]
        full = solved(hessian[s], scale, TINY_DAMPING, downhill, free)
        damped = solved(hessian[s], scale, damping[s], downhill, free)
        for i in range(d):
            step[s, i] = min(max(z[s, i] + damped[i], limits[0, i]), limits[1, i]) - z[s, i]
            full_gain[s] -= gradient[s, i] * full[i]
        for i in range(d):
            pull, after = 2.0 * gradient[s, i], gradient[s, i]
            for j in range(d):
                pull += hessian[s, i, j] * step[s, j]
                after += hessian[s, i, j] * full[j]
            gain[s] -= pull * step[s, i]
            # A full step may turn a frozen unknown's gradient inward: there is more to gain then.
            if not free[i] and after * gradient[s, i] < 0.0:
                full_gain[s] = np.inf
    return step, gain, full_gain


@accelerated
def judged(
    squares: Array,
    tried: Array,
    gain: Array,
    damping: Array,
    growth: Array,
    rejections: AnyArray,
    fastest_shrink: float,
) -> BoolArray:
    """Return which trials (P,) cost less, and adapt damping, growth and rejections (P,) in place.

    Nielsen's rule: the better the gain was predicted, the less damping, but not less than
    `fastest_shrink` of it at once. A step clipped at the box
    may even predict a loss; that, and a trial that is not finite, counts as rejected.
    """
    won = np.zeros(squares.size, dtype=np.bool_)
    for s in range(squares.size):
        ratio = (squares[s] - tried[s]) / gain[s] if gain[s] > 0.0 else -1.0
        won[s] = ratio > 0.0  # false for NaN
        if won[s]:
            damping[s] *= max(fastest_shrink, 1.0 - (2.0 * min(ratio, 1.0) - 1.0) ** 3)
            growth[s] = 2.0
            rejections[s] = 0
        else:
            damping[s] *= growth[s]
            growth[s] *= 2.0
            rejections[s] += 1
    return won
