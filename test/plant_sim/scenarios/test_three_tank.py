import pytest

from plant_sim.scenarios.three_tank import THREE_TANK_FAULTS
from plant_sim.simulation import Simulation


@pytest.mark.parametrize(
    ('t', 'openings'),
    [
        (0.0, (1.0, 1.0, 1.0)), (999.9, (1.0, 1.0, 1.0)), (1000.0, (0.7, 0.5, 1.0)),
        (1999.9, (0.7, 0.5, 1.0)), (2000.0, (0.4, 0.5, 0.5)), (9999.0, (0.4, 0.5, 0.5)),
    ],
)  # fmt: skip
def test_valves_close_at_1000_and_2000_s(t, openings):
    assert THREE_TANK_FAULTS.parameters(t) == openings


def test_levels_at_the_first_fault_are_those_of_the_paper():
    run = Simulation(THREE_TANK_FAULTS, snr_db=float('inf'))
    for _ in range(1001):
        instant = run.sample()
    assert instant.t == 1000.0
    assert instant.x == pytest.approx((21.25897, 14.17197, 17.71669), abs=1e-4)
