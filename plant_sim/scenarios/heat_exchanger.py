"""A heat exchanger with two valves, in three cases: Zhang et al. 2020, section 4.3, and our own.

The measured temperatures carry an Ornstein-Uhlenbeck noise of 0.05 K that is correlated over 0.1 s
(the paper says coloured, and no more).
"""

import math
from dataclasses import replace

from obs_ros.models.heat_exchanger import HEAT_EXCHANGER
from plant_sim.scenario import Scenario
from plant_sim.signals import Schedule, constant

NOMINAL = tuple(v.nominal or 0.0 for v in HEAT_EXCHANGER.parameters)  # dP1, dP2, k1, k2
PRESSURES = tuple(v.nominal or 0.0 for v in HEAT_EXCHANGER.inputs)  # Pa
AT_REST = tuple(v.nominal or 0.0 for v in HEAT_EXCHANGER.states[2:])
NOISE = 0.05  # K
HALF_PERIOD = 5.0  # s


def square_waves(t: float) -> tuple[float, ...]:
    """Return pc1 and pc2 (Pa), of which the first rises by 20 % while the second falls as much."""
    changed = int(t // HALF_PERIOD) % 2
    return PRESSURES[0] * (1.2 if changed else 1.0), PRESSURES[1] * (0.8 if changed else 1.0)


# Nothing changes: how fast do observers find the flows?
CONSTANT_FLOWS = Scenario(
    name='heat_exchanger_case1',
    model='heat_exchanger',
    initial_state=(80.0, 20.0, *AT_REST),
    inputs=constant(*PRESSURES),
    parameters=constant(*NOMINAL),
    sample_period=1e-3,
    duration=60.0,
    snr_db=-20.0 * math.log10(NOISE),
    noise_correlation=0.1,
    reference='Zhang et al. 2020, section 4.3.1',
)

# The utility valve clogs at 80 s (dP1), the spring of the process valve hardens at 150 s (k2).
VALVE_FAULTS = replace(
    CONSTANT_FLOWS,
    name='heat_exchanger_case2',
    parameters=Schedule(
        times=(0.0, 80.0, 150.0),
        values=(
            NOMINAL,
            (4.0e5, *NOMINAL[1:]),
            (4.0e5, *NOMINAL[1:3], NOMINAL[3] + 1000.0),
        ),
    ),
    duration=220.0,
    reference='Zhang et al. 2020, section 4.3.2',
)

# Pressures move: here an observer that knows the valves has what others lack.
MOVING_VALVES = replace(
    CONSTANT_FLOWS,
    name='heat_exchanger_case3',
    initial_state=(24.303, 20.108, *AT_REST),
    inputs=square_waves,
    reference='after Zhang et al. 2020, with the pressures of both valves in motion',
)
