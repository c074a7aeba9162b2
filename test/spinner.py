"""A shaft that turns, measured by a sensor of its angle that wraps, and windows of it."""

from typing import Any

import numpy as np

from obs_ros import Model, Record, Variable
from obs_ros.core.periods import within
from obs_ros.core.typing import Array
from obs_ros.integration.grid import Grid
from obs_ros.integration.vectorised import NumpyKernels

TURN = 2.0 * np.pi
TRUTH = {'k': 3.0, 'c': 0.5}


def shaft_dynamics(t: Any, x: Any, u: Any, p: Any) -> tuple[Any, Any]:
    return x[1], p[0] * u[0] - p[1] * x[1]


def shaft_output(t: Any, x: Any, u: Any, p: Any) -> tuple[Any, Any]:
    return x[0], 0.1 * x[1]


def shaft(
    period: float | None = TURN, lower: float = -np.pi, upper: float = np.pi, **more: Any
) -> Model:
    """angle' = rate, rate' = k torque - c rate; the angle wraps, a tenth of the rate does not."""
    return Model(
        name='shaft',
        states=(
            Variable('angle', 'rad', lower, upper, period=period),
            Variable('rate', 'rad/s', -40.0, 40.0),
        ),
        inputs=(Variable('torque'),),
        outputs=(Variable('angle', 'rad', period=period), Variable('tenth', 'rad/s')),
        parameters=(Variable('k', '1/s2', 0.1, 20.0), Variable('c', '1/s', 0.01, 5.0)),
        dynamics=shaft_dynamics,
        output=shaft_output,
        max_step=0.05,
        **more,
    )


SHAFT = shaft()
UNWRAPPED = shaft(None, -100.0, 100.0)


def truth(t: Array, torque: Array, angle: float, rate: float) -> Array:
    """States (K, 2) along times (K,) under torques (K,) that hold."""
    record = Record(t, torque, np.zeros((t.size, 2)))
    grid = Grid.of(UNWRAPPED, record, np.ones(2))
    x0, p = np.array([[angle], [rate]]), np.array([[value] for value in TRUTH.values()])
    return NumpyKernels(UNWRAPPED).trajectories(grid, x0, p)[0][:, :, 0]


def window(
    angle: float = 2.8,
    rate: float = 0.0,
    *,
    nodes: int = 61,
    interval: float = 0.05,
    torque: float = 0.0,
    swing: float = 5.0,
    noise: float = 0.02,
    seed: int = 0,
) -> tuple[Record, Record, Array]:
    """A window of the wrapped angle alone, the same without wraps, and the true states (K, 2).

    Both begin at the same number.
    """
    t = interval * np.arange(nodes)
    u = torque + swing * np.sin(3.0 * t)
    states = truth(t, u, angle, rate)
    y = np.full((nodes, 2), np.nan)
    y[:, 0] = states[:, 0] + noise * np.random.default_rng(seed).standard_normal(nodes)
    period = np.array([TURN, 0.0])
    wrapped = within(y, period)
    straight = y + np.array([np.round((wrapped[0, 0] - y[0, 0]) / TURN) * TURN, 0.0])
    return Record(t, u, wrapped), Record(t, u, straight), states
