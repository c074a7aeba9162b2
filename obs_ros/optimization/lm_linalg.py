"""The small linear algebra of Levenberg-Marquardt, for a batch of starts.

Loops, compiled where Numba is: on matrices of a few rows, calls of NumPy would take longer than
the rollouts.
"""

import functools
import math

import numpy as np

from obs_ros.core.jit import unhurried
from obs_ros.core.typing import AnyArray, Array, BoolArray

TINY_DAMPING = 1e-11  # keeps a singular matrix solvable
TINY = 1e-200  # guards divisions by the scale of an unknown without influence
RULES = 8  # numbers of `LMSettings.rules`


@functools.cache
def prepare() -> None:
    """Compile what is below, or load it compiled: at the first solve it would cost its deadline."""
    a, one = np.ones(1), np.ones((1, 1))
    count, rules, limits = np.ones(1, dtype=np.int64), np.ones(RULES), np.ones((2, 1))
    state = one, a, one, one[None], a.copy(), count
    proposed(*state, a.copy(), limits, 1.0, True, rules)
    last_step(*state[:4], limits, 1.0, 1.0, rules)
    moved(*state, a.copy(), one, a, a, one, one[None], 1.0)


@unhurried
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


@unhurried
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


@unhurried
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
            better = 2.0 * min(ratio, 1.0) - 1.0
            damping[s] *= max(fastest_shrink, 1.0 - better * better * better)
            growth[s] = 2.0
            rejections[s] = 0
        else:
            damping[s] *= growth[s]
            growth[s] *= 2.0
            rejections[s] += 1
    return won


@unhurried
def usable(squares: float, hessian: Array) -> bool:
    """Whether residuals and derivatives of one start are finite, by its J'J (d, d)."""
    finite = math.isfinite(squares)
    for i in range(len(hessian)):
        for j in range(len(hessian)):
            finite = finite and math.isfinite(hessian[i, j])
    return finite


@unhurried
def difference_steps(hessian: Array, variance: float, rules: Array, h: Array) -> None:
    """Write steps h (d,) of finite differences for noise of this variance, near J'J (d, d)."""
    for i in range(h.size):
        step = rules[5] * np.sqrt(variance / max(hessian[i, i], TINY))
        h[i] = min(max(step, rules[6]), rules[7])


@unhurried
def proposed(
    z: Array,
    squares: Array,
    gradient: Array,
    hessian: Array,
    damping: Array,
    rejections: AnyArray,
    mark: Array,
    limits: Array,
    variance: float,
    marked: bool,
    rules: Array,
) -> tuple[Array, Array, Array, BoolArray, BoolArray, int]:
    """Return trial points (P, d), gains (P,) foretold, and steps (P, d) of the differences there.

    Also which starts have converged (P,), and which are over (P,) with their number: they have
    converged, stalled or crept. Arguments are those of `damped_steps`; `variance` is that of the
    noise, `rules` are those of `LMSettings`. Where this one is `marked`, gains since the last mark
    (P,) count, and the next begin.
    """
    count, d = z.shape
    trial, gain, full_gain = damped_steps(z, gradient, hessian, damping, limits, rules[0])
    h = np.empty((count, d))
    converged, over = np.zeros(count, dtype=np.bool_), np.zeros(count, dtype=np.bool_)
    enough, number = rules[1] * d * variance, 0
    for s in range(count):
        inside = True
        for i in range(d):
            trial[s, i] += z[s, i]
            inside = inside and limits[0, i] < trial[s, i] < limits[1, i]
        converged[s] = full_gain[s] < enough
        over[s] = (
            converged[s]
            or (inside and gain[s] <= rules[2] * d * variance)
            or rejections[s] >= rules[4]
            or damping[s] >= rules[3]
        )
        if marked:
            over[s] = over[s] or mark[s] - squares[s] < enough
            mark[s] = squares[s]
        number += over[s]
        difference_steps(hessian[s], variance, rules, h[s])
    return trial, gain, h, converged, over, number


@unhurried
def moved(
    z: Array,
    squares: Array,
    gradient: Array,
    hessian: Array,
    damping: Array,
    rejections: AnyArray,
    growth: Array,
    trial: Array,
    gain: Array,
    tried: Array,
    gradient_there: Array,
    hessian_there: Array,
    fastest_shrink: float,
) -> None:
    """Go to the trial points that cost less, and adapt the damping to the gains foretold.

    In place: z, squares, gradients and Hessians of the starts become those of what was tried. A
    trial whose residuals or derivatives are not finite costs more.
    """
    for s in range(squares.size):
        if not usable(tried[s], hessian_there[s]):
            tried[s] = np.inf
    won = judged(squares, tried, gain, damping, growth, rejections, fastest_shrink)
    # Number by number: assigning arrays compiles a message on their shapes, for seconds.
    for s in range(squares.size):
        if won[s]:
            squares[s] = tried[s]
            for i in range(z.shape[1]):
                z[s, i], gradient[s, i] = trial[s, i], gradient_there[s, i]
                for j in range(z.shape[1]):
                    hessian[s, i, j] = hessian_there[s, i, j]


@unhurried
def last_step(
    z: Array,
    squares: Array,
    gradient: Array,
    hessian: Array,
    limits: Array,
    least: float,
    variance: float,
    rules: Array,
) -> tuple[Array, Array, bool]:
    """Return the point (1, d) to which a full step leads, and steps (1, d) of differences there.

    From the one start z (1, d). And whether that gains more than the `least` that counts.
    """
    trial, h = z.copy(), np.empty((1, z.shape[1]))
    if not usable(squares[0], hessian[0]):
        return trial, h, False
    damping = np.full(1, TINY_DAMPING)
    step, _, gain = damped_steps(z, gradient, hessian, damping, limits, rules[0])
    for i in range(z.shape[1]):
        trial[0, i] += step[0, i]
    difference_steps(hessian[0], variance, rules, h[0])
    return trial, h, gain[0] > least
