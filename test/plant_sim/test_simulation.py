import math

import numpy as np
import pytest

from plant_sim.scenarios import load_scenario
from plant_sim.simulation import Simulation

THREE_TANK = load_scenario('three_tank')
# spec/three_tank_chaotic_de.md: Radau, checked; at 1000, 2000 and 3000 s.
LEVELS = {
    1000: (21.25897, 14.17197, 17.71669),
    2000: (59.53719, 49.96477, 52.93330),
    3000: (86.27335, 52.72873, 65.42825),
}


@pytest.mark.parametrize('period', [1.0, 12.5])
def test_three_tanks_reach_the_levels_of_an_independent_solver(period):
    simulation = Simulation(THREE_TANK, period=period, snr_db=math.inf)
    reached = {i.t: i for i in (simulation.sample() for _ in range(round(3000 / period) + 1))}
    for t, levels in LEVELS.items():
        assert reached[t].x == pytest.approx(levels, abs=1e-5)
        assert reached[t].y == reached[t].x[:2]
    assert [reached[t].p for t in (0, 1000, 2000)] == list(THREE_TANK.parameters.values)


def test_changes_between_samples_happen_on_their_time():
    simulation = Simulation(THREE_TANK, period=300.0, snr_db=math.inf)
    instants = [simulation.sample() for _ in range(11)]
    assert instants[-1].x == pytest.approx(LEVELS[3000], abs=1e-5)


def test_noise_is_seeded_and_as_strong_as_asked():
    def outputs(**options):
        simulation = Simulation(THREE_TANK, **options)
        return np.array([simulation.sample().y for _ in range(2000)])

    exact = outputs(snr_db=math.inf)
    noisy = outputs(seed=5, snr_db=20.0)
    assert np.array_equal(noisy, outputs(seed=5, snr_db=20.0))
    assert (noisy - exact).std() == pytest.approx(0.1, rel=0.08)


def test_measured_power_scales_the_noise_to_each_output():
    simulation = Simulation(THREE_TANK, snr_db=20.0, noise_reference='measured')
    quiet = Simulation(THREE_TANK, snr_db=math.inf)
    pairs = [(simulation.sample().y, quiet.sample().y) for _ in range(3000)]
    noisy, exact = np.array(pairs).transpose(1, 0, 2)
    rms = np.sqrt(np.mean(exact**2, axis=0))
    assert (noisy - exact).std(axis=0) / rms == pytest.approx([0.1, 0.1], rel=0.08)


def test_a_fault_holds_whatever_is_scheduled_until_it_is_taken_away():
    simulation = Simulation(THREE_TANK, period=100.0)
    for _ in range(6):
        simulation.sample()
    simulation.faults['p1'] = 0.2
    assert {simulation.sample().p[0] for _ in range(10)} == {0.2}
    simulation.faults.clear()
    assert simulation.sample().p[0] == 0.7


def test_a_period_that_is_not_positive_is_refused():
    with pytest.raises(ValueError, match='not positive'):
        Simulation(THREE_TANK, period=0.0)
