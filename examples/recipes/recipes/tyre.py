"""A car in a slalom: the single-track model, whose tyres push back in proportion to their slip."""

import math

from obs_ros import Model, Variable
from plant_sim.scenario import Scenario
from plant_sim.signals import Schedule

MASS, INERTIA, SPEED = 1500.0, 2500.0, 15.0  # kg, kg m2 about the vertical, m/s
FRONT, REAR = 1.2, 1.5  # m from the centre of mass to the axles


def dynamics(t, x, u, p):
    side, yaw_rate = x  # m/s to the left, rad/s
    front, rear = p
    pull_front = 1e3 * front * (u[0] - (side + FRONT * yaw_rate) / SPEED)  # N
    pull_rear = -1e3 * rear * (side - REAR * yaw_rate) / SPEED
    return (
        (pull_front + pull_rear) / MASS - SPEED * yaw_rate,
        (FRONT * pull_front - REAR * pull_rear) / INERTIA,
    )


CAR = Model(
    name='car',
    states=(Variable('side', 'm/s', -5, 5), Variable('yaw_rate', 'rad/s', -2, 2)),
    inputs=(Variable('steer', 'rad', nominal=0),),
    outputs=(Variable('yaw_rate', 'rad/s'), Variable('sideways', 'm/s2')),
    parameters=(
        Variable('front', 'kN/rad', lower=5, upper=300, nominal=80, scale='log'),
        Variable('rear', 'kN/rad', lower=5, upper=300, nominal=80, scale='log'),
    ),
    dynamics=dynamics,
    # An accelerometer measures the forces of the tyres by the mass.
    output=lambda t, x, u, p: (x[1], dynamics(t, x, u, p)[0] + SPEED * x[1]),
    reference='single-track model, linear tyres',
)


def slalom(t):
    """Return the angle of the front wheels in rad."""
    return (0.03 * math.sin(2.0 * t) + 0.02 * math.sin(5.1 * t),)


SLALOM = Scenario(
    name='slalom',
    model='recipes.tyre:CAR',
    initial_state=(0.0, 0.0),  # m/s, rad/s
    inputs=slalom,
    parameters=Schedule((0.0, 20.0), ((70.0, 90.0), (70.0, 65.0))),  # a rear tyre loses its air
    sample_period=0.02,  # s
    duration=40.0,  # s
    snr_db=46.0,  # noise of 0.005 rad/s and m/s2
)
