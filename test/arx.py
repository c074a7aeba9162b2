"""A difference equation of second order, a discrete model, and its textbook Kalman filter."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from obs_ros import Model, Sample, Variable
from obs_ros.core.typing import Array

PERIOD = 0.1  # s
A = (1.5, -0.7)  # poles of size .84
B = 0.2
X0 = (1.0, 0.5)
TENTH = 10**7  # ns: a tenth of the period


def next_state(t: Any, x: Any, u: Any, p: Any) -> Any:
    """y_(k+1) = a1 y_k + a2 y_(k-1) + b u_k, with the last output beside the present one."""
    now, last = x
    a1, a2, b = p
    return a1 * now + a2 * last + b * u[0], now


ARX = Model(
    name='arx',
    states=(Variable('now', lower=-10, upper=10), Variable('last', lower=-10, upper=10)),
    inputs=(Variable('u', nominal=0.0),),
    outputs=(Variable('y'),),
    parameters=(
        Variable('a1', lower=-2, upper=2, nominal=A[0]),
        Variable('a2', lower=-1, upper=1, nominal=A[1]),
        Variable('b', lower=0, upper=1, nominal=B),
    ),
    dynamics=next_state,
    output=lambda t, x, u, p: (x[0],),
    kind='discrete',
    period=PERIOD,
)
F, G, H = np.array([A, (1.0, 0.0)]), np.array([B, 0.0]), np.array([1.0, 0.0])


def pushes(count: int, seed: int = 0) -> Array:
    """Return inputs (count,) of -1 and 1 at random."""
    return np.random.default_rng(seed).choice([-1.0, 1.0], count)


def course(u: Array, walk: float = 0.0, noise: float = 0.0, seed: int = 1) -> tuple[Array, Array]:
    """Return states (K, 2) under inputs u (K,), and noisy outputs (K,).

    The first state walks by `walk` per root of a second.
    """
    rng, x = np.random.default_rng(seed), np.array(X0)
    states = []
    for uk in u:
        states.append(x)
        x = F @ x + G * uk + np.array([walk * np.sqrt(PERIOD) * rng.standard_normal(), 0.0])
    return np.array(states), np.array(states)[:, 0] + noise * rng.standard_normal(u.size)


class Filtered(NamedTuple):
    """Means (K, 2) and covariances (K, 2, 2) after each node's output, innovations (K,)."""

    means: Array
    covariances: Array
    innovations: Array


def kalman_filter(
    u: Array, y: Array, z: Sequence[float], P: Array, walks: Sequence[float], noise: float
) -> Filtered:
    """The filter for nodes one after the other, every node with an input; NaN = not measured."""
    mean, found, Q = np.array(z), [], PERIOD * np.diag(walks) ** 2
    for k in range(u.size):
        if k > 0:
            mean, P = F @ mean + G * u[k - 1], F @ P @ F.T + Q
        e = y[k] - H @ mean
        if np.isfinite(e):
            K = P @ H / (H @ P @ H + noise**2)
            J = np.eye(2) - np.outer(K, H)
            mean, P = mean + K * e, J @ P @ J.T + noise**2 * np.outer(K, K)
        found.append((mean, P, e))
    return Filtered(*(np.array(part) for part in zip(*found, strict=True)))


def samples(u: Array, y: Array, offsets: Sequence[float] = (), since: int = 0) -> list[Sample]:
    """Return samples of the nodes, `offsets` (K,) periods off; outputs that are NaN are missing."""
    found = []
    for k, (uk, yk) in enumerate(zip(u, y, strict=True)):
        off = round(1e9 * PERIOD * offsets[k]) if len(offsets) else 0
        stamp = since + round(1e9 * PERIOD * k) + off
        measured = None if np.isnan(yk) else np.array([yk])
        found.append(Sample(stamp, y=measured, u=np.array([uk])))
    return found


def fixed(model: Model = ARX) -> Model:
    """Return the model with parameters that are known."""
    return replace(model, parameters=(), dynamics=lambda t, x, u, p: next_state(t, x, u, (*A, B)))
