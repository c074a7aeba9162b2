"""A plant's functions on arrays, compiled, with steps of their own: nothing of obs_ros integrates.

The simulation and the reference stand on these.
"""

import functools
from collections.abc import Callable
from typing import Any

import numpy as np

from obs_ros import Model
from obs_ros.core.jit import accelerated
from obs_ros.core.rebuild import Rebuilder
from obs_ros.core.typing import Array

Simulate = Callable[[Array, Array, Array, Array, Array, Array], None]
Neg2LogLikelihood = Callable[..., float]

NUDGE = 1e-6


def on_arrays(function: Any, entries: int, inputs: int, states: int, parameters: int) -> Any:
    """Return a plant's function with arrays for its tuples, and `out` (entries,) for its result."""
    x, u, p = (
        ''.join(f'{name}[{i}], ' for i in range(count))
        for name, count in (('x', states), ('u', inputs), ('p', parameters))
    )
    lines = ['def filled(t, x, u, p, out):', f'    found = function(t, ({x}), ({u}), ({p}))']
    lines += [f'    out[{i}] = found[{i}]' for i in range(entries)]
    plain = accelerated(Rebuilder(accelerated, __name__).copy(function))
    scope: dict[str, Any] = {'function': plain, '__name__': __name__}
    exec('\n'.join(lines), scope)
    return accelerated(scope['filled'])


@functools.cache
def functions_of(model: Model) -> tuple[Any, Any]:
    """Return `step(t, x, u, p, h, work)`, a step of RK4 in place, and `measure(t, x, u, p, y)`."""
    sizes = len(model.inputs), len(model.states), len(model.parameters)
    rates = on_arrays(model.dynamics, len(model.states), *sizes)

    def step(t: float, x: Array, u: Array, p: Array, h: float, work: Array) -> None:
        k1, k2, k3, k4, at = work
        rates(t, x, u, p, k1)
        at[:] = x + 0.5 * h * k1
        rates(t + 0.5 * h, at, u, p, k2)
        at[:] = x + 0.5 * h * k2
        rates(t + 0.5 * h, at, u, p, k3)
        at[:] = x + h * k3
        rates(t + h, at, u, p, k4)
        x += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)

    return accelerated(step), on_arrays(model.output, len(model.outputs), *sizes)


@functools.cache
def simulation_of(model: Model) -> Simulate:
    """Return `simulate(t, u, p, pushes, x, y)` of inputs (K, m) held from sample to sample.

    pushes (K - 1, S, n) are added after each of the S steps in an interval; x (n,) is moved from
    the first sample to the last, y (K, r) is filled in.
    """
    step, measure = functions_of(model)

    def simulate(t: Array, u: Array, p: Array, pushes: Array, x: Array, y: Array) -> None:
        work = np.empty((5, x.size))
        for k in range(t.size):
            measure(t[k], x, u[k], p, y[k])
            if k < t.size - 1:
                h = (t[k + 1] - t[k]) / pushes.shape[1]
                for i in range(pushes.shape[1]):
                    step(t[k] + i * h, x, u[k], p, h, work)
                    x += pushes[k, i]

    return accelerated(simulate)


@accelerated
def predict(P: Array, F: Array, Q: Array, dt: float, FP: Array) -> None:
    """Turn P (n, n) into F P F' + dt/6 (Q + (I + F) Q (I + F)' + F Q F'), Q (n,) a diagonal."""
    n = Q.size
    for a in range(n):
        for b in range(n):
            FP[a, b] = 0.0
            for c in range(n):
                FP[a, b] += F[a, c] * P[c, b]
    for a in range(n):
        for b in range(n):
            P[a, b] = 0.0
            for c in range(n):
                noises = F[a, c] * F[b, c] + (F[a, c] + (a == c)) * (F[b, c] + (b == c))
                P[a, b] += FP[a, c] * F[b, c] + dt / 6.0 * Q[c] * noises
        P[a, a] += dt / 6.0 * Q[a]


@accelerated
def update(x: Array, P: Array, C: Array, off: Array, noise: Array, work: Array) -> float:
    """Correct x (n,) and P (n, n) by outputs that are `off` (r,); return their -2 log p.

    Their derivatives are C (r, n).
    """
    correction, PC, total = work[0], work[1], 0.0
    correction[:] = 0.0
    for i in range(off.size):
        S, e = noise[i] ** 2, off[i]
        for a in range(x.size):
            PC[a] = 0.0
            for b in range(x.size):
                PC[a] += P[a, b] * C[i, b]
            S += C[i, a] * PC[a]
            e -= C[i, a] * correction[a]
        total += np.log(S) + e * e / S
        for a in range(x.size):
            correction[a] += PC[a] * e / S
            for b in range(x.size):
                P[a, b] -= PC[a] * PC[b] / S
    x += correction
    return total


@functools.cache
def likelihood_of(model: Model) -> Neg2LogLikelihood:
    """Return `neg2(t, u, y, x0, p, walks, noise, size, steps)`, -2 log p(y) but for a constant.

    By an extended Kalman filter: the initial state x0 (n,) is exact; walks (n,) and noise (r,) are
    deviations; derivatives are differences by NUDGE of `size` (n,), in `steps` steps an interval.
    """
    step, measure = functions_of(model)

    def neg2(
        t: Array, u: Array, y: Array, x0: Array, p: Array, walks: Array, noise: Array, size: Array,
        steps: int,
    ) -> float:  # fmt: skip
        n, r = x0.size, y.shape[1]
        x, P, Q, F, FP = x0.copy(), np.zeros((n, n)), walks**2, np.empty((n, n)), np.empty((n, n))
        C, lane, h, work = np.empty((r, n)), np.empty(n), np.empty(r), np.empty((5, n))
        predicted, before, total = np.empty(r), np.empty(n), 0.0
        for k in range(t.size):
            for i in range(steps if k > 0 else 0):
                dt = (t[k] - t[k - 1]) / steps
                at = t[k - 1] + i * dt
                before[:] = x
                step(at, x, u[k - 1], p, dt, work)
                for j in range(n):
                    lane[:] = before
                    lane[j] += NUDGE * size[j]
                    step(at, lane, u[k - 1], p, dt, work)
                    F[:, j] = (lane - x) / (NUDGE * size[j])
                predict(P, F, Q, dt, FP)
            measure(t[k], x, u[k], p, predicted)
            for j in range(n):
                lane[:] = x
                lane[j] += NUDGE * size[j]
                measure(t[k], lane, u[k], p, h)
                C[:, j] = (h - predicted) / (NUDGE * size[j])
            total += update(x, P, C, y[k] - predicted, noise, work)
        return total

    return accelerated(neg2)
