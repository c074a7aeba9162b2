"""A driven pendulum: its rate, stiffness and friction from the angle alone."""

import numpy as np

from obs_ros import Model, Variable


def dynamics(t, x, u, p):  # x' in SI or your own units
    angle, rate = x
    stiffness, friction = p
    return rate, u[0] - stiffness * np.sin(angle) - friction * rate


def output(t, x, u, p):
    return (x[0],)


PENDULUM = Model(
    name='pendulum',
    states=(Variable('angle', 'rad', lower=-3, upper=3), Variable('rate', 'rad/s', -9, 9)),
    inputs=(Variable('torque', '1/s2', nominal=0),),
    outputs=(Variable('angle', 'rad'),),
    parameters=(
        Variable('stiffness', '1/s2', lower=1, upper=30, nominal=9.81),
        Variable('friction', '1/s', lower=0, upper=2, nominal=0.1),
    ),
    dynamics=dynamics,
    output=output,
)
