"""A spring whose speed is stamped late, and on which a force acts late."""

from typing import Any

import numpy as np

from obs_ros import Model, Record, Variable
from obs_ros.core.typing import Array


def spring_dynamics(t: Any, x: Any, u: Any, p: Any) -> tuple[Any, Any]:
    k, c = p
    return x[1], u[0] - k * x[0] - c * x[1]


def spring(speed: Any = None, force: Any = None, max_step: float = 0.02) -> Model:
    return Model(
        name='spring',
        states=(Variable('position', 'm', -5.0, 5.0), Variable('velocity', 'm/s', -20.0, 20.0)),
        inputs=(Variable('force', 'N', delay=force),),
        outputs=(Variable('y', 'm'), Variable('speed', 'm/s', delay=speed)),
        parameters=(Variable('k', lower=1.0, upper=200.0), Variable('c', lower=0.0, upper=5.0)),
        dynamics=spring_dynamics,
        output=lambda t, x, u, p: (x[0], x[1]),
        max_step=max_step,
    )


def force_of(rng: np.random.Generator, seconds: float) -> Array:
    """A force at 50 Hz from 1 s before the window on, new every 0.2 s."""
    count = round((1.0 + seconds) / 0.02) + 1
    return np.repeat(10.0 * rng.standard_normal(count // 10 + 1), 10)[:count]


def measured(
    rng: np.random.Generator,
    speed: float,
    force: float,
    k: float = 40.0,
    c: float = 0.8,
    friction: float = 0.0,
) -> tuple[Record, Array]:
    """3 s of the spring at 40 dB, integrated in 1 ms, and the noise of its outputs.

    Sampled every 20 ms; the speed was measured so many s before its stamp, the force acts so late.
    Dry `friction` is none that the model knows.
    """
    u = force_of(rng, 3.0)
    fine = 0.001 * np.arange(-500, 3501)
    sent = np.clip(np.floor((fine + 0.0005 - force + 1.0) / 0.02 + 1e-9), 0, u.size - 1)
    x, states = np.array([0.5, 0.0]), []
    for now in u[sent.astype(int)]:
        states.append(x)
        A = np.array([[0.0, 1.0], [-k, -c]])
        rate = A @ x + [0.0, now - friction * np.tanh(x[1] / 0.02)]
        x = x + 0.001 * (rate + 0.0005 * A @ (rate + 0.001 / 3.0 * A @ rate))
    position, velocity = np.array(states).T
    t = 0.02 * np.arange(151)
    y = np.column_stack([np.interp(t, fine, position), np.interp(t - speed, fine, velocity)])
    sigma = 0.01 * y.std(axis=0)
    y += sigma * rng.standard_normal(y.shape)
    at = 0.02 * np.arange(-50, 151)
    return Record(at, u, np.vstack([np.full((50, 2), np.nan), y])), sigma


def plain_window(record: Record) -> Record:
    """The window without what comes before it."""
    return Record(record.t[50:], record.u[50:], record.y[50:])
