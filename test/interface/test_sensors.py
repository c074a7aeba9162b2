"""Sensors and actuators as parameters declare them."""

import math
from dataclasses import replace

import pytest
from spinner import shaft

from obs_ros.core.estimated_delays import plain
from obs_ros.interface.bindings import signal_parameters
from obs_ros.interface.sensors import sensor_parameters, with_sensors
from obs_ros.models import load_model
from obs_ros.replay.settings import setup

TANKS = load_model('three_tank')


def declared(model=TANKS, **given):
    """The model with parameters given as `h1_range=...`."""
    named = {f'signals.{name.replace("_", ".")}': value for name, value in given.items()}
    values = {s.name: s.coerce(named.pop(s.name, s.default)) for s in signal_parameters(model)}
    assert not named
    return with_sensors(model, values)


def test_outputs_have_four_parameters_and_inputs_two_all_at_start_only():
    specs = sensor_parameters(TANKS)
    assert [spec.name.removeprefix('signals.') for spec in specs] == [
        'Q1.delay', 'Q1.range', 'Q2.delay', 'Q2.range',
        'h1.delay', 'h1.period', 'h1.range', 'h1.resolution',
        'h2.delay', 'h2.period', 'h2.range', 'h2.resolution',
    ]  # fmt: skip
    assert all(spec.read_only and spec.coerce(spec.default) == spec.default for spec in specs)


def test_values_that_say_what_the_model_says_leave_it_the_very_same():
    assert declared() is TANKS
    known = declared(h1_resolution=0.5, Q1_range=[0, 100])
    assert declared(known) is known


def test_values_replace_those_of_the_variables():
    model = declared(h1_delay=[0, 2], h2_delay=-1, h2_period=7.0, Q2_range=[0, math.inf])
    h1, h2 = model.outputs
    assert (h1.delay, h2.delay, h2.period) == ((0.0, 2.0), -1.0, 7.0)
    assert model.inputs[1].range == (0.0, math.inf) and model.inputs[0] == TANKS.inputs[0]
    assert plain(model.dynamics) is TANKS.dynamics


def test_what_the_model_declares_is_the_default_and_can_be_taken_back():
    outputs = (replace(TANKS.outputs[0], delay=(0.0, 1.0), resolution=0.5), TANKS.outputs[1])
    model = replace(TANKS, outputs=outputs)
    specs = {spec.name: spec for spec in sensor_parameters(model)}
    assert specs['signals.h1.delay'].default == (0.0, 1.0)
    bare = declared(model, h1_delay=0.0, h1_resolution=0.0)
    assert bare == TANKS


@pytest.mark.parametrize(
    ('given', 'reason'),
    [
        ({'h1_range': [1.0, 0.0]}, 'signals.h1.range: the low end 1.0 of its range is not below'),
        ({'h1_range': [math.nan, 0.0]}, r'signals.h1.range must be a number cm, not nan'),
        ({'h1_delay': [1.0, 0.5]}, 'signals.h1.delay: delay from 1.0 s is not below its upper'),
        ({'h1_delay': 1e7}, r'signals.h1.delay must be -1e6 to 1e6 s, not 1e\+?07|10000000.0'),
        ({'h1_period': -1.0}, 'signals.h1.period must be 0 to 1e100 cm, not -1.0'),
        ({'h1_resolution': math.inf}, 'signals.h1.resolution must be 0 to 1e100 cm, not inf'),
        ({'h1_resolution': 'fine'}, "signals.h1.resolution must be a number, not 'fine'"),
    ],
)
def test_what_cannot_be_is_refused_by_the_name_of_the_parameter(given, reason):
    with pytest.raises(ValueError, match=reason):
        declared(**given)


def test_a_replay_takes_them_without_a_topic():
    chosen = setup({'signals.h1.resolution': 0.5, 'signals.Q1.delay': [0, 3]})
    assert chosen.model.outputs[0].resolution == 0.5 and chosen.bound == {}
    assert chosen.model.inputs[0].delay == (0.0, 3.0) and chosen.remarks == ()
    with pytest.raises(ValueError, match='only outputs have a resolution'):
        setup({'signals.Q1.resolution': 0.5})


def test_a_state_of_the_name_of_an_output_wraps_with_it_where_the_model_does():
    plain = shaft(None)
    model = declared(plain, angle_period=2.0 * math.pi)
    assert [state.period for state in model.states] == [2.0 * math.pi, None]
    assert declared(plain, angle_period=1.0).states[0].period == 1.0, 'a shaft has any period'
    own = (replace(plain.states[0], period=0.5), plain.states[1])
    assert declared(replace(plain, states=own), angle_period=1.0).states[0].period == 0.5
    levels = declared(h1_period=360.0)
    assert levels.outputs[0].period == 360.0 and levels.states == TANKS.states
