import math

import pytest
from rclpy.node import Node
from ros import set_parameter

from obs_ros.knob import Knob, markdown_table
from obs_ros.models import load_model
from obs_ros.node import settings
from obs_ros.node.parameters import Parameters
from plant_sim import settings as plant_settings

GAIN = Knob('gain', 1.0, 'loop gain', 'V/cm', lower=0.0, upper=5.0)
WORD = Knob('word', '', 'what to do', choices=('', 'stay', 'leave'))
LIMITS = Knob('limits', (0.0, 1.0), 'lower and upper', length=2)
LABEL = Knob('label', 'x', 'a label', read_only=True)
TANKS = load_model('three_tank')
ALL_KNOBS = (
    *settings.CHOICE, *settings.LIVE, *settings.COMMON, *settings.model_knobs(TANKS),
    *plant_settings.CHOICE, *plant_settings.COMMON, *plant_settings.fault_knobs(TANKS),
)  # fmt: skip


def test_integers_pass_where_floats_are_meant():
    assert GAIN.coerce(2) == 2.0 and isinstance(GAIN.coerce(2), float)
    assert LIMITS.coerce([0, 1]) == (0.0, 1.0)


@pytest.mark.parametrize(
    ('knob', 'value', 'text'),
    [
        (GAIN, 6.0, 'gain must be 0 to 5 V/cm, not 6.0'),
        (GAIN, math.nan, 'gain must be 0 to 5 V/cm, not nan'),
        (GAIN, True, 'gain must be a number, not True'),
        (GAIN, None, 'gain must be a number, not None'),
        (WORD, 'leaf', "unknown word 'leaf': did you mean 'leave'?"),
        (LIMITS, [1.0], 'limits must have 2 entries, not 1'),
        (LIMITS, '[0, 1]', "limits must be an array like [0.0, 1.0], not '[0, 1]'"),
    ],
)
def test_wrong_values_are_refused_with_the_reason(knob, value, text):
    with pytest.raises(ValueError) as caught:
        knob.coerce(value)
    assert str(caught.value) == text


@pytest.mark.parametrize('knob', ALL_KNOBS, ids=lambda knob: knob.name)
def test_every_default_is_allowed_and_described(knob):
    assert knob.coerce(knob.default) is knob.default or knob.coerce(knob.default) == knob.default
    assert knob.default != () and knob.description
    assert f'`{knob.name}`' in markdown_table([knob])


def make_node(**options):
    return Node('node', automatically_declare_parameters_from_overrides=True, **options)


def test_what_the_user_gives_is_declared_with_the_type_of_the_knob(ros):
    node = ros.start(make_node, gain=3, label='y')
    parameters = Parameters(node)
    parameters.declare([GAIN, WORD, LIMITS, LABEL])
    assert parameters.values == {'gain': 3.0, 'word': '', 'limits': (0.0, 1.0), 'label': 'y'}
    assert isinstance(node.get_parameter('gain').value, float)
    descriptor = node.describe_parameter('gain')
    assert descriptor.description == 'loop gain (in V/cm; 0 to 5)'
    assert descriptor.additional_constraints == '0 to 5'
    assert node.describe_parameter('label').read_only


def test_changes_are_proposed_first_and_adopted_once_they_stand(ros):
    node = ros.start(make_node)
    parameters, adopted = Parameters(node), []

    def propose(values):
        if values['gain'] > 4.0 and values['word'] != 'stay':
            raise ValueError('too much gain to leave')
        return values['gain']

    parameters.declare([GAIN, WORD])
    parameters.watch(propose, adopted.append)
    assert adopted == [1.0]
    assert set_parameter(node, 'gain', 2).successful
    answer = set_parameter(node, 'gain', 4.5)
    assert not answer.successful and answer.reason == 'too much gain to leave'
    assert adopted == [1.0, 2.0] and parameters.values['gain'] == 2.0
    assert set_parameter(node, 'word', 'stay').successful
    assert set_parameter(node, 'gain', 4.5).successful
    assert not set_parameter(node, 'gain', None).successful, 'it cannot be deleted'
    assert node.get_parameter('gain').value == parameters.values['gain'] == 4.5


def test_a_misspelt_parameter_is_named_with_what_may_have_been_meant(ros, capfd):
    node = ros.start(make_node, gian=3.0)
    parameters = Parameters(node)
    parameters.declare([GAIN])
    parameters.watch(dict, lambda _: None)
    assert "there is no parameter 'gian': did you mean 'gain'?" in capfd.readouterr().err
