"""Two third-order plants under four sinusoids: Gremling & Passino 2000, sections 4 and 5.

The adaptive Luenberger observer of the paper works in continuous time, and so does the input here:
held for 0.01 s it would come 5 ms late.
"""

import math
from dataclasses import replace

from plant_sim.scenario import Scenario
from plant_sim.signals import constant


def four_sinusoids(t: float) -> tuple[float]:
    """Return the input of section 4.1."""
    return (
        1.5 * math.sin(3.2 * t)
        + 3.9 * math.cos(1.9 * t)
        - 2.6 * math.sin(0.7 * t)
        - 2.1 * math.cos(2.5 * t),
    )


MINIMUM_PHASE = Scenario(
    name='observer_form_third_order',
    model='observer_form_third_order',
    initial_state=(0.0, 0.0, 0.0),
    inputs=four_sinusoids,
    held=False,
    parameters=constant(2.1, 2.1, 1.0, 1.0, 0.9, 0.8),
    sample_period=0.01,
    duration=100.0,
    snr_db=math.inf,
    reference='Gremling & Passino 2000, section 4',
)
NON_MINIMUM_PHASE = replace(
    MINIMUM_PHASE,
    name='observer_form_third_order_nmp',
    model='observer_form_third_order_nmp',
    parameters=constant(2.9, 2.91, 0.959, 0.0, 1.0, -0.05),
    reference='Gremling & Passino 2000, section 5',
)
