"""A damped pendulum pushed by a torque; the angle is measured."""

from typing import Any

import numpy as np

from benchmarks.zoo.output import first_state
from obs_ros import Model, Variable


def dynamics(t: Any, x: Any, u: Any, p: Any) -> tuple[Any, Any]:
    """Angle and rate of a pendulum under gravity, friction and torque."""
    angle, rate = x
    stiffness, friction, gain = p
    return rate, gain * u[0] - stiffness * np.sin(angle) - friction * rate


PENDULUM = Model(
    name='pendulum',
    states=(
        Variable('angle', unit='rad', lower=-3.0, upper=3.0),
        Variable('rate', unit='rad/s', lower=-5.0, upper=5.0),
    ),
    inputs=(Variable('torque', unit='N m', interpolation='linear'),),
    outputs=(Variable('angle', unit='rad'),),
    parameters=(
        Variable('stiffness', unit='1/s2', lower=2.0, upper=20.0, nominal=9.81),
        Variable('friction', unit='1/s', lower=0.0, upper=1.0, nominal=0.1),
        Variable('gain', unit='1/(kg m2)', lower=0.2, upper=3.0, nominal=1.0),
    ),
    dynamics=dynamics,
    output=first_state,
    max_step=0.05,
)
