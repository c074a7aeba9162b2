"""Parameters of faults: what they make of sensors and actuators, and what is refused."""

import math
from dataclasses import replace

import pytest

from obs_ros.models import load_model
from plant_sim.actuators import Actuator
from plant_sim.fault_settings import (
    actuators,
    check_faults,
    fault_parameters,
    instrument_parameters,
    plant_faults,
    sensors,
    told,
)
from plant_sim.sensors import Sensor

TANKS = load_model('three_tank')
ROWS = (*fault_parameters(TANKS), *instrument_parameters(TANKS))
DEFAULTS = {row.name: row.default for row in ROWS}


def test_each_plant_parameter_can_be_held_within_its_bounds() -> None:
    rows = fault_parameters(TANKS)
    assert [row.name for row in rows] == ['plant.p1', 'plant.p2', 'plant.p3']
    assert all(math.isnan(row.default) and (row.lower, row.upper) == (0.0, 1.0) for row in rows)
    assert plant_faults(DEFAULTS | {'plant.p2': 0.5}) == {'p2': 0.5}


def test_nothing_is_broken_by_itself() -> None:
    fresh = DEFAULTS | {'sensor.h1.outlier_value': float('nan')}
    assert sensors(TANKS, fresh) == {} == actuators(TANKS, fresh)
    assert told(TANKS, fresh) == 'none'
    check_faults(TANKS, fresh, 1.0)


def test_defaults_are_what_the_model_declares_and_can_be_taken_away() -> None:
    model = replace(
        TANKS,
        inputs=(replace(TANKS.inputs[0], delay=3.0, range=(0.0, 50.0)), TANKS.inputs[1]),
        outputs=(replace(TANKS.outputs[0], resolution=0.5), *TANKS.outputs[1:]),
    )
    declared = {row.name: row.default for row in instrument_parameters(model)}
    assert sensors(model, declared) == {'h1': Sensor(resolution=0.5)}
    assert actuators(model, declared) == {'Q1': Actuator(delay=3.0, range=(0.0, 50.0))}
    ideal = declared | {
        'sensor.h1.resolution': 0.0, 'actuator.Q1.delay': 0.0, 'actuator.Q1.range': (0.0, 0.0)
    }  # fmt: skip
    assert sensors(model, ideal) == {} == actuators(model, ideal)
    scheduled = {row.name: row.default for row in fault_parameters(model)}
    assert told(model, declared | scheduled) == 'none'
    assert told(model, ideal | scheduled) == (
        'sensor.h1.resolution=0, actuator.Q1.delay=0, actuator.Q1.range=[0.0, 0.0]'
    )
    with pytest.raises(ValueError, match=r'^shorten actuator.Q1.delay, or lower rate'):
        check_faults(model, declared, 1e-3)


def test_a_delay_that_is_estimated_is_a_parameter_of_its_instrument_alone() -> None:
    inputs = [replace(v, delay=(0.0, 5.0)) for v in TANKS.inputs]
    model = replace(TANKS, inputs=inputs)
    assert len(model.parameters) == 5
    assert fault_parameters(model) == fault_parameters(TANKS)
    assert instrument_parameters(model) == instrument_parameters(TANKS)


def test_what_is_set_breaks_its_own_sensor_or_actuator() -> None:
    values = DEFAULTS | {
        'sensor.h2.outlier_rate': 0.01,
        'sensor.h2.outlier_value': 0.0,
        'sensor.h2.range': (0.0, 50.0),
        'actuator.Q1.delay': 3.0,
        'plant.p1': 0.2,
    }
    assert sensors(TANKS, values) == {
        'h2': Sensor(outlier_rate=0.01, outlier_value=0.0, range=(0.0, 50.0))
    }
    assert actuators(TANKS, values) == {'Q1': Actuator(delay=3.0)}
    assert told(TANKS, values) == (
        'p1=0.2, sensor.h2.outlier_rate=0.01, sensor.h2.outlier_value=0, '
        'sensor.h2.range=[0.0, 50.0], actuator.Q1.delay=3'
    )
    check_faults(TANKS, values, 1.0)


@pytest.mark.parametrize(
    ('name', 'value', 'reason'),
    [
        ('sensor.h1.range', (2.0, 1.0), r'sensor.h1.range must be \[lower, upper\]'),
        ('actuator.Q1.range', (2.0, 2.0), 'actuator.Q1.range must be wider than'),
        ('sensor.h1.outlier_size', (9.0, 3.0), 'sensor.h1.outlier_size must be'),
        ('sensor.h1.delay', -200.0, '^shorten sensor.h1.delay, or lower rate: 200 s are 2e\\+03'),
        ('actuator.Q2.delay', 101.0, '^shorten actuator.Q2.delay, or lower rate'),
    ],
)
def test_what_makes_no_sense_or_would_block_is_refused(
    name: str, value: object, reason: str
) -> None:
    with pytest.raises(ValueError, match=reason):
        check_faults(TANKS, DEFAULTS | {name: value}, 0.1)


def test_an_offset_in_time_of_too_many_steps_is_refused() -> None:
    jet = load_model('jet_engine')
    values = {row.name: row.default for row in instrument_parameters(jet)}
    name = f'sensor.{jet.outputs[0].name}.delay'
    assert jet.max_step * 1e5 < 1e6
    with pytest.raises(ValueError, match=f'^shorten {name}: in .* the plant takes'):
        check_faults(jet, values | {name: 2e5 * jet.max_step}, 1e6)
