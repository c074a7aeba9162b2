"""Every observer is measured on a scenario that suits it."""

import pytest

from benchmarks.observer_costs.report import asked
from benchmarks.observer_costs.run import FORM, SCENARIOS, WINDOW, Cost
from benchmarks.play import played, samples_of
from obs_ros import load_model, load_observer
from obs_ros.observers.base import OBSERVERS
from plant_sim.scenarios import load_scenario


@pytest.mark.parametrize('name', OBSERVERS)
def test_every_observer_is_measured_on_a_scenario_that_suits_it(name: str) -> None:
    scenario = SCENARIOS.get(name, FORM)
    model = load_model(load_scenario(scenario).model)
    settings = WINDOW if name == 'sliding_window' else {}
    observer = load_observer(name)(model, **settings)
    instants = played(scenario, 3, seed=0)
    assert len(instants[0].p) == len(model.parameters)
    assert observer.absorb(samples_of(instants)[0]) == observer.immediate


def test_times_are_held_against_what_is_asked() -> None:
    costs = [Cost('ekf', '', 25.0, 30.0, 1.0), Cost('gase', '', 900.0, 950.0, 1.0),
             Cost('high_gain', '', 99.0, 99.0, 1.0)]  # fmt: skip
    assert [(row.asked, row.met) for row in asked(costs)] == [
        ('ekf: absorb, median <= 20 us', False), ('gase: absorb, median <= 1000 us', True)
    ]  # fmt: skip
