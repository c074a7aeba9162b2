"""Bindings of outputs and inputs to fields of messages, as parameters give them."""

import pytest

from obs_ros.interface.bindings import Binding, bindings, signal_parameters
from obs_ros.interface.field_path import FieldPath
from obs_ros.models import load_model

TANKS = load_model('three_tank')
FLOAT, JOINTS = 'std_msgs/msg/Float64', 'sensor_msgs/msg/JointState'


def bound(name, unknown=(), **given):
    values = {spec.name: spec.default for spec in signal_parameters(TANKS)}
    return bindings(
        TANKS, values | {f'signals.{name}.{part}': value for part, value in given.items()}, unknown
    )


def test_each_output_and_input_has_six_parameters_of_its_topic_and_those_of_its_sensor():
    names = [spec.name for spec in signal_parameters(TANKS)]
    assert len(names) == 6 * (len(TANKS.outputs) + len(TANKS.inputs)) + 4 * 2 + 2 * 2
    assert 'signals.Q1.topic' in names and all(spec.read_only for spec in signal_parameters(TANKS))


def test_without_bindings_there_are_none():
    values = {spec.name: spec.default for spec in signal_parameters(TANKS)}
    assert bindings(TANKS, values) == {}


def test_a_binding_is_what_its_parameters_say():
    found = bound('h2', topic='/b', type=JOINTS, field='position[h]', scale=100.0, offset=-1.0)
    path = FieldPath.parse('position[h]')
    assert found == {'h2': Binding('h2', '/b', JOINTS, path, 100.0, -1.0, 'header')}


@pytest.mark.parametrize(
    ('given', 'reason'),
    [
        ({'type': FLOAT}, 'signals.h1.type is given, but signals.h1.topic is not'),
        ({'scale': 2.0}, 'signals.h1.scale is given, but signals.h1.topic is not'),
        ({'topic': '/a', 'field': 'x'}, 'signals.h1.topic is given, but signals.h1.type is not'),
        ({'topic': '/a', 'type': FLOAT}, 'signals.h1.topic is given, but signals.h1.field is not'),
        ({'topic': '/a', 'type': FLOAT, 'field': '[0]'}, "signals.h1.field: '\\[0\\]' is not a"),
        ({'topic': '/a', 'type': FLOAT, 'field': 'data', 'scale': 0.0}, 'other than 0'),
        (
            {'topic': '/a', 'type': FLOAT, 'field': 'data', 'offset': float('inf')},
            'signals.h1.offset must be a finite number',
        ),
        ({'unknown': ['signals.h1.topc']}, "no parameter 'signals.h1.topc': did you mean 'topic'"),
        ({'unknown': ['signals.h1.resoltion']}, "did you mean 'resolution'"),
        (
            {'unknown': ['signals.Q1.resolution']},
            'signals.Q1.resolution: Q1 is one of the inputs, but only outputs have a resolution',
        ),
        ({'unknown': ['signals.h9.range']}, "no output or input 'h9': did you mean 'h2' or 'h1'"),
        ({'unknown': ['signals.h9.topic']}, "no output or input 'h9': did you mean 'h2' or 'h1'"),
    ],
)
def test_what_cannot_be_is_refused(given, reason):
    with pytest.raises(ValueError, match=reason):
        bound('h1', **given)
