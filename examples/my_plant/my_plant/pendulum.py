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
    states=(
        Variable('angle', unit='rad', lower=-3.0, upper=3.0),
        Variable('rate', unit='rad/s', lower=-9.0, upper=9.0),
    ),
    inputs=(Variable('torque', unit='1/s2', nominal=0.0),),
    outputs=(Variable('angle', unit='rad'),),
    parameters=(
        Variable('stiffness', unit='1/s2', lower=1.0, upper=30.0, nominal=9.81),
        Variable('friction', unit='1/s', lower=0.0, upper=2.0, nominal=0.1),
    ),
    dynamics=dynamics,
    output=output,
    max_step=0.02,  # s
)
