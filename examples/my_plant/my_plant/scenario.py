"""Rigs that are not there yet: `ros2 run obs_ros simulator` plays a pendulum and a heater."""

from plant_sim.scenario import Scenario
from plant_sim.signals import Schedule

PUSHES = (0.25, -0.25, 0.0, 0.25, 0.25, -0.25, 0.0, -0.25)  # 1/s2, each for half a second


def push(t):
    return (PUSHES[int(2.0 * t) % len(PUSHES)],)


SWINGS = Scenario(
    name='swings',
    model='my_plant.pendulum:PENDULUM',
    initial_state=(0.4, 0.0),  # rad, rad/s
    inputs=push,
    parameters=Schedule((0.0, 30.0), ((8.0, 0.3), (6.5, 0.3))),  # 30 s on, a weight slips
    sample_period=0.02,  # s
    duration=120.0,  # s
    snr_db=40.0,  # noise of 0.01 rad
)


def heat(t):
    return (60.0 if t % 60.0 < 30.0 else 20.0,)


BAKES = Scenario(
    name='bakes',
    model='my_plant.heater:HEATER',
    initial_state=(0.0, 0.0),  # K, %
    inputs=heat,
    parameters=Schedule((0.0, 600.0), ((0.95, 0.05), (0.92, 0.05))),  # later a fan cools it
    sample_period=2.0,  # s
    duration=1200.0,  # s
    snr_db=20.0,  # noise of 0.1 K
)
