"""The glycolytic oscillator's five experiments: Porter & Passino 1995, eq. 17 and cases 1-4.

Model mismatch is a plant that uses up its substrate at a = 0.8 1/s while the model's nominal rate
is 1; in the paper it comes on top of the white input.
"""

import math
from dataclasses import replace

from plant_sim.scenario import Scenario
from plant_sim.scenarios.linear_second_order import two_cosines
from plant_sim.signals import constant
from plant_sim.sources import WhiteGaussian


def one_cosine(t: float) -> tuple[float]:
    """Return the feed that makes the oscillator chaotic, in 1/s."""
    return (0.999 + 0.42 * math.cos(1.75 * t),)


def three_hertz(t: float) -> tuple[float]:
    """Return the disturbance of the measured substrate."""
    return (0.1 * math.sin(2.0 * math.pi * 3.0 * t),)


BASE = Scenario(
    name='glycolytic_oscillator',
    model='glycolytic_oscillator',
    initial_state=(1.5, 1.5),
    inputs=two_cosines,
    parameters=constant(1.0, 1.0),  # 1/s
    sample_period=0.01,
    duration=20.0,
    snr_db=math.inf,
    reference='Porter & Passino 1995, eqs. 16-17',
)
CHAOTIC = replace(
    BASE,
    name='glycolytic_oscillator_chaotic',
    inputs=one_cosine,
    reference='Porter & Passino 1995, eq. 17, case 1',
)
DISTURBED = replace(
    CHAOTIC,
    name='glycolytic_oscillator_disturbed',
    disturbance=three_hertz,
    reference='Porter & Passino 1995, eq. 17, case 2',
)
GAUSSIAN = replace(
    BASE,
    name='glycolytic_oscillator_gaussian',
    inputs=WhiteGaussian(mean=1.25, deviation=0.5),
    reference='Porter & Passino 1995, eq. 17, case 3',
)
MISMATCH = replace(
    GAUSSIAN,
    name='glycolytic_oscillator_mismatch',
    parameters=constant(0.8, 1.0),
    reference='Porter & Passino 1995, eq. 17, case 4',
)
