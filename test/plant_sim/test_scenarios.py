import dataclasses

import numpy as np
import pytest

from plant_sim.scenarios import SCENARIOS, load_scenario
from plant_sim.signals import constant
from plant_sim.simulation import Simulation


@pytest.mark.parametrize('name', SCENARIOS)
def test_every_scenario_plays_to_its_end_with_finite_numbers(name):
    scenario = load_scenario(name)
    assert scenario.name == name and scenario.reference
    simulation = Simulation(scenario, seed=1)
    samples = round(min(scenario.duration, 300 * simulation.period) / simulation.period)
    instants = [simulation.sample() for _ in range(samples)]
    assert instants[0].t == 0.0 and instants[0].x == scenario.initial_state
    assert all(np.isfinite([*i.x, *i.y, *i.u, *i.p]).all() for i in instants)


def test_unknown_names_bring_close_ones():
    with pytest.raises(ValueError, match="did you mean 'three_tank'"):
        load_scenario('three_tnak')
    with pytest.raises(ValueError, match='is a Model, not a'):
        load_scenario('obs_ros.models.three_tank:THREE_TANK')


def test_a_scenario_must_fit_its_model():
    with pytest.raises(ValueError, match='inputs'):
        dataclasses.replace(load_scenario('three_tank'), inputs=constant(30.0))
