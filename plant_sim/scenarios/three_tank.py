"""Three tanks, two sets of valve faults: Yang, Li & Dahhou 2020, section 5.

The valves are open, then close in part at 1000 s and further at 2000 s, while both pumps run
steadily.
"""

from plant_sim.scenario import Scenario
from plant_sim.signals import Schedule, constant

THREE_TANK_FAULTS = Scenario(
    name='three_tank',
    model='three_tank',
    initial_state=(0.0, 0.0, 60.0),  # cm
    inputs=constant(30.0, 30.0),  # cm3/s
    parameters=Schedule(
        times=(0.0, 1000.0, 2000.0),
        values=((1.0, 1.0, 1.0), (0.7, 0.5, 1.0), (0.4, 0.5, 0.5)),
    ),
    sample_period=1.0,
    duration=3000.0,
    snr_db=40.0,
    reference='Yang, Li & Dahhou 2020, section 5',
)
