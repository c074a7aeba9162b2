import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from obs_ros import load_model
from plant_sim.scenarios import SCENARIOS, load_scenario
from plant_sim.simulation import Simulation

# Until a bump and both pressures of the 1 kHz scenarios are passed; `make check` goes to the end.
SOON = 13500
LONG = [
    name for name in SCENARIOS if (each := load_scenario(name)).duration / each.sample_period > SOON
]


def check_bounds(name, most=math.inf, slower=1):
    """Play a scenario, at most so many samples, and hold each value against the model's bounds."""
    scenario = load_scenario(name)
    simulation = Simulation(scenario, seed=1, period=slower * scenario.sample_period)
    samples = min(round(scenario.duration / simulation.period), most) + 1
    instants = [simulation.sample() for _ in range(samples)]
    assert instants[0].t == 0.0 and instants[0].x == scenario.initial_state
    assert instants[-1].t == pytest.approx(min(scenario.duration, most * simulation.period))
    assert np.isfinite([i.y for i in instants]).all()
    model = load_model(scenario.model)
    for values, variables in (
        ([i.x for i in instants], model.states),
        ([i.u for i in instants], model.inputs),
        ([i.p for i in instants], model.parameters),
    ):
        for column, variable in zip(np.transpose(values), variables, strict=True):
            assert variable.lower <= column.min(), variable.name
            assert column.max() <= variable.upper, variable.name


@pytest.mark.slow
@pytest.mark.parametrize('name', LONG)
def test_a_long_scenario_stays_inside_the_bounds_of_its_model_to_the_end(name):
    """At a quarter of its rate, which takes half the time."""
    check_bounds(name, slower=4)


@pytest.mark.parametrize('name', SCENARIOS)
class TestEveryScenario:
    def test_it_stays_inside_the_bounds_of_its_model(self, name):
        scenario = load_scenario(name)
        assert scenario.name == name and scenario.reference
        check_bounds(name, SOON)

    def test_the_same_seed_plays_the_same_bits(self, name):
        one, same = (Simulation(load_scenario(name), seed=2, snr_db=40.0) for _ in range(2))
        assert [one.sample() for _ in range(50)] == [same.sample() for _ in range(50)]


PAPERS_OF_PASSINO = [
    name
    for name in SCENARIOS
    if name.startswith(('glycolytic', 'jet_engine', 'linear', 'observer_form'))
]


@pytest.mark.parametrize('name', PAPERS_OF_PASSINO)
def test_the_plant_follows_an_independent_solver(name):
    """DOP853 from sample to sample for 5 s, under the inputs that were applied."""
    scenario = load_scenario(name)
    simulation = Simulation(scenario, seed=1)
    instants = [simulation.sample() for _ in range(501)]
    assert simulation.period == 0.01
    x = np.array(instants[0].x)
    for now in instants[:-1]:
        x = solve_ivp(
            lambda t, x, now=now: simulation.model.dynamics(
                t, x, now.u if scenario.held else scenario.inputs(t), now.p
            ),
            (now.t, now.t + 0.01), x, 'DOP853', rtol=1e-10, atol=1e-12,
        ).y[:, -1]  # fmt: skip
    assert instants[-1].x == pytest.approx(x, abs=1e-7)


def test_unknown_names_bring_close_ones():
    with pytest.raises(ValueError, match="did you mean 'three_tank'"):
        load_scenario('three_tnak')
    with pytest.raises(ValueError, match='is a Model, not a'):
        load_scenario('obs_ros.models.three_tank:THREE_TANK')
