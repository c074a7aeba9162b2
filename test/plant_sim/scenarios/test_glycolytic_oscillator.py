import math

import pytest

from obs_ros import load_model
from plant_sim.scenarios.glycolytic_oscillator import BASE, DISTURBED, MISMATCH
from plant_sim.simulation import Simulation


def test_the_nominal_rates_of_the_mismatched_oscillator_are_wrong():
    assert MISMATCH.parameters(0.0) == (0.8, 1.0)
    assert [v.nominal for v in load_model(MISMATCH.model).parameters] == [1.0, 1.0]
    assert BASE.parameters(0.0) == (1.0, 1.0)


def test_three_hertz_lie_on_the_disturbed_measurement():
    simulation = Simulation(DISTURBED)
    instants = [simulation.sample() for _ in range(201)]
    error = [i.y[0] - i.x[0] for i in instants]
    expected = [0.1 * math.sin(6.0 * math.pi * i.t) for i in instants]
    assert error == pytest.approx(expected, abs=1e-12) and max(error) > 0.099
