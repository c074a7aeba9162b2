"""The simulator's parameters, and rates that would block it."""

import pytest

from obs_ros.models import load_model
from plant_sim.scenarios import SCENARIOS, load_scenario
from plant_sim.settings import check_rate, usage

TANKS = load_model('three_tank')


@pytest.mark.parametrize(
    ('values', 'reason'),
    [
        ({'rate': 1e-6, 'noise_reference': 'unit'}, '^raise rate: from one sample to the next'),
        ({'rate': 1e4, 'noise_reference': 'measured'}, '^lower rate, or let noise_reference be'),
    ],
)
def test_rates_that_would_block_the_node_are_refused(values, reason):
    with pytest.raises(ValueError, match=reason):
        check_rate(load_scenario('three_tank'), TANKS, values)
    check_rate(load_scenario('three_tank'), TANKS, values | {'rate': 1.0})


def test_the_help_names_every_scenario_and_parameter():
    text = ' '.join(usage().split())
    assert all(name in text for name in SCENARIOS)
    assert all(f'{name} (' in text for name in ('scenario', 'speed', 'seed', 'noise_reference'))
    assert all(f'  {name}\n' in usage() for name in ('plant.NAME', 'sensor.OUTPUT.delay'))
