"""A linear plant under two cosines: Porter & Passino 1995, eqs. 12-16.

The paper prints the cosines over k; t is meant: at 1.75 rad per sample the plant would hardly move.
"""

import math

from plant_sim.scenario import Scenario
from plant_sim.signals import constant


def two_cosines(t: float) -> tuple[float]:
    """Return the input of eq. 16 in 1/s."""
    return (0.999 + 0.42 * math.cos(1.75 * t) + 0.32 * math.cos(4.5 * t),)


TWO_COSINES = Scenario(
    name='linear_second_order',
    model='linear_second_order',
    initial_state=(1.5, 1.5),
    inputs=two_cosines,
    parameters=constant(-2.25, -4.5, -5.5),  # 1/s
    sample_period=0.01,
    duration=20.0,
    snr_db=math.inf,
    reference='Porter & Passino 1995, eqs. 12-16',
)
