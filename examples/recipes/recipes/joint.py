"""A robot arm's joint that lifts a payload: one link under gravity, with friction."""

import math

import numpy as np

from obs_ros import Model, Variable
from plant_sim.scenario import Scenario
from plant_sim.signals import Schedule

G, REACH = 9.81, 0.6  # m/s2, m from the axis to the payload
LINK, INERTIA = 1.5, 0.2  # kg m and kg m2 of the link itself


def dynamics(t, x, u, p):
    angle, rate = x  # from hanging down
    payload, viscous, coulomb = p
    weight = G * (LINK + payload * REACH) * np.sin(angle)
    friction = viscous * rate + coulomb * np.tanh(rate / 0.05)
    return rate, (u[0] - weight - friction) / (INERTIA + payload * REACH**2)


JOINT = Model(
    name='joint',
    states=(Variable('angle', 'rad', -3, 3), Variable('rate', 'rad/s', -10, 10)),
    inputs=(Variable('torque', 'N m', nominal=0),),
    outputs=(Variable('angle', 'rad'),),
    parameters=(
        Variable('payload', 'kg', lower=0, upper=10, nominal=1, physical='lower'),
        Variable('viscous', 'N m s', lower=0, upper=10, nominal=1, physical='lower'),
        Variable('coulomb', 'N m', lower=0, upper=10, nominal=0.5, physical='lower'),
    ),
    dynamics=dynamics,
    output=lambda t, x, u, p: (x[0],),
    reference='one link, viscous and Coulomb friction',
)


def swings(t):
    """Return the torque in N m: two sines, which lift the arm and let it down."""
    return (8.0 * math.sin(1.1 * t) + 4.0 * math.sin(2.7 * t),)


PICKS = Scenario(
    name='picks',
    model='recipes.joint:JOINT',
    initial_state=(0.1, 0.0),  # rad, rad/s
    inputs=swings,
    parameters=Schedule((0.0, 30.0), ((0.5, 1.2, 0.8), (2.0, 1.2, 0.8))),  # 30 s on it picks up
    sample_period=0.01,  # s
    duration=60.0,  # s
    snr_db=60.0,  # noise of 0.001 rad
)
