"""A scenario fits its model, or is refused."""

import dataclasses

import pytest

from plant_sim.scenarios import load_scenario
from plant_sim.signals import constant


@pytest.mark.parametrize(
    ('field', 'values'),
    [
        ('inputs', constant(30.0)),
        ('disturbance', constant(0.1)),
        ('parameters', constant(1.0)),
        ('initial_state', (1.0,)),
    ],
)
def test_a_scenario_must_fit_its_model(field, values):
    with pytest.raises(ValueError, match=f'{field.replace("_", " ")} .* one entry for each of'):
        dataclasses.replace(load_scenario('three_tank'), **{field: values})


@pytest.mark.parametrize(
    ('change', 'reason'),
    [
        ({'sample_period': 0.0}, 'periods and durations must be positive'),
        ({'duration': -1.0}, 'periods and durations must be positive'),
        ({'noise_correlation': -0.1}, 'noise_correlation -0.1 s is negative'),
    ],
)
def test_times_that_cannot_be_are_refused(change, reason):
    with pytest.raises(ValueError, match=reason):
        dataclasses.replace(load_scenario('three_tank'), **change)


def test_only_a_signal_runs_on_between_samples():
    held, running = load_scenario('three_tank'), load_scenario('observer_form_third_order')
    assert held.running_inputs is None and running.running_inputs is running.inputs
    with pytest.raises(ValueError, match='only a signal can run on between samples'):
        dataclasses.replace(load_scenario('jet_engine_case1'), held=False)
