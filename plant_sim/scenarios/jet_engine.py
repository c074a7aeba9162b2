"""A jet engine's compressor under pressure control: Gremling & Passino 2000, section 6.

The reference is drawn in a figure of the paper only. This ramp down the characteristic and up again
keeps what matters: which way the compressor fails hangs on the mass flow that it starts from. In
case 1 it runs without stall for four seconds, then stalls for good; in case 2 it stalls at once,
the cells die out again, and the flow stays reversed.
"""

import math
from dataclasses import replace

from plant_sim.scenario import Scenario
from plant_sim.signals import constant, ramp
from plant_sim.sources import PIController

PRESSURE_RISE = ramp(times=(0.0, 17.0, 25.0), values=(2.6, 1.3, 1.7))

CASE_1 = Scenario(
    name='jet_engine_case1',
    model='jet_engine',
    initial_state=(0.5, 0.1, 1.4),  # Psi, R, Phi
    inputs=PIController(kp=5.0, ki=2.0, reference=PRESSURE_RISE),
    parameters=constant(1.5, 1.5, 0.5, 3.0, 0.4823, 7.0),
    sample_period=0.01,
    duration=25.0,
    snr_db=math.inf,
    reference='Gremling & Passino 2000, section 6, case 1',
)
CASE_2 = replace(
    CASE_1,
    name='jet_engine_case2',
    initial_state=(0.5, 0.1, 0.8),
    reference='Gremling & Passino 2000, section 6, case 2',
)
