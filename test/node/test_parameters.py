import re

import pytest
import yaml
from interface.test_parameters import clashing
from rcl_interfaces.msg import Parameter as ParameterMessage
from rcl_interfaces.srv import SetParameters
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.node import Node
from rclpy.parameter import Parameter, get_parameter_value
from ros import set_parameter
from std_msgs.msg import String

from obs_ros.core.parameter_spec import ParameterSpec
from obs_ros.replay.settings import setup
from obs_ros.ros.estimator import Estimator
from obs_ros.ros.messages import LATCHED
from obs_ros.ros.parameters import Parameters, given_at_start
from plant_sim.node import Simulator

GAIN = ParameterSpec('gain', 1.0, 'loop gain', 'V/cm', lower=0.0, upper=5.0)
WORD = ParameterSpec('word', '', 'what to do', choices=('', 'stay', 'leave'))
LIMITS = ParameterSpec('limits', (0.0, 1.0), 'lower and upper', length=2)
LABEL = ParameterSpec('label', 'x', 'a label', read_only=True)


@pytest.mark.parametrize('kind', [Estimator, Simulator])
def test_no_parameter_of_a_node_is_a_value_and_a_prefix(ros, kind):
    """Those that ROS declares, QoS and all, among them."""
    node = ros.start(kind)
    names = set(node.get_parameters_by_prefix(''))
    assert any(name.startswith('qos_overrides.') for name in names) == (kind is Estimator)
    assert 'use_sim_time' in names and not clashing(names)


@pytest.mark.parametrize(
    ('old', 'value', 'new'),
    [('predict', True, 'prediction.enabled'), ('predict.rate', 2.0, 'prediction.rate')],
)
def test_old_names_are_refused_with_the_new_one(ros, old, value, new):
    with pytest.raises(ValueError, match=f'^{re.escape(old)} is now {re.escape(new)}'):
        ros.start(Estimator, **{old: value})
    with pytest.raises(ValueError, match=f'^{re.escape(old)} is now {re.escape(new)}'):
        setup({old: value})


def make_node(**options):
    return Node('node', automatically_declare_parameters_from_overrides=True, **options)


def test_what_the_user_gives_is_declared_with_the_type_of_its_row(ros):
    node = ros.start(make_node, gain=3, label='y')
    parameters = Parameters(node, given_at_start(node))
    parameters.declare([GAIN, WORD, LIMITS, LABEL])
    assert parameters.values == {'gain': 3.0, 'word': '', 'limits': (0.0, 1.0), 'label': 'y'}
    assert isinstance(node.get_parameter('gain').value, float)
    descriptor = node.describe_parameter('gain')
    assert descriptor.description == 'loop gain (in V/cm; 0 to 5)'
    assert descriptor.additional_constraints == '0 to 5'
    assert node.describe_parameter('label').read_only


def test_changes_are_proposed_first_and_adopted_once_they_stand(ros):
    node = ros.start(make_node)
    parameters, adopted = Parameters(node, given_at_start(node)), []

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
    parameters = Parameters(node, given_at_start(node))
    parameters.declare([GAIN])
    parameters.watch(dict, lambda _: None)
    assert "there are no such parameters: 'gian' (did you mean 'gain'?)" in capfd.readouterr().err


def swing_settings(ros, *cli, **parameters):
    return ros.start(Estimator, *cli, model='node.fakes:SWING', **parameters)


def asked(ros, name, value):
    """Set one parameter of the estimator as `ros2 param set` does; return the answer."""
    request = ParameterMessage(name=name, value=get_parameter_value(value))
    return ros.call('/estimator/set_parameters', SetParameters, parameters=[request]).results[0]


def test_bounds_of_a_model_written_as_integers_take_floats_and_integers(ros):
    node = swing_settings(ros)
    for text, taken in (
        ('[-2, 2]', [-2.0, 2.0]), ('[-1.5, 2.5]', [-1.5, 2.5]), ('[0, 1]', [0.0, 1.0]),
    ):  # fmt: skip
        assert asked(ros, 'bounds.angle', text).successful
        assert list(node.get_parameter('bounds.angle').value) == taken
        assert node.get_parameter('bounds.angle').type_ is Parameter.Type.DOUBLE_ARRAY
    for name in ('fixed.stiffness', 'initial.rate', 'noise.angle', 'stale_after'):
        assert asked(ros, name, '2').successful, name
        assert asked(ros, name, '2.5').successful, name
        assert node.get_parameter(name).value == 2.5
    # The command makes text of a mixed array.
    answer = asked(ros, 'bounds.angle', '[1, 2.5]')
    assert not answer.successful and 'DOUBLE_ARRAY' in answer.reason
    assert asked(ros, 'bounds.angle', '[1.0, 2.5]').successful


def test_process_noise_off_needs_no_quotes(ros):
    node = swing_settings(ros, '--ros-args', '-p', 'process_noise:=off')
    assert node.get_parameter('process_noise').value == 'off'
    for text, taken in (('auto', 'auto'), ('off', 'off')):
        assert asked(ros, 'process_noise', text).successful
        assert node.get_parameter('process_noise').value == taken


def test_integers_on_the_command_line_and_in_a_file_are_floats_too(ros, tmp_path):
    file = tmp_path / 'swing.yaml'
    file.write_text(
        '/**:\n  ros__parameters:\n    bounds: {angle: [-2, 2]}\n    noise: {angle: 1}\n'
        '    signals.angle: {topic: x, type: std_msgs/msg/Float64, field: data, scale: 2,'
        ' stamp: arrival}\n'
    )
    given = ('-p', 'bounds.rate:=[-1, 1]', '-p', 'window.duration:=4')
    node = swing_settings(ros, '--ros-args', '--params-file', str(file), *given)
    values = {
        name: node.get_parameter(name).value
        for name in ('bounds.angle', 'bounds.rate', 'noise.angle', 'signals.angle.scale')
    }
    assert {name: list(v) if name.startswith('b') else v for name, v in values.items()} == {
        'bounds.angle': [-2.0, 2.0], 'bounds.rate': [-1.0, 1.0], 'noise.angle': 1.0,
        'signals.angle.scale': 2.0,
    }  # fmt: skip
    assert all(isinstance(v, float) for v in (*values['bounds.angle'], *values['bounds.rate']))


def test_an_array_of_two_types_at_start_is_an_error_of_rcl(ros):
    with pytest.raises(rclpy_implementation.RCLError, match='Sequence should be of same type'):
        swing_settings(ros, '--ros-args', '-p', 'bounds.angle:=[1, 2.5]')


def test_walks_and_priors_change_live_and_are_shown(ros):
    node = swing_settings(ros)
    infos = ros.listen('/estimator/info', String, LATCHED)
    assert ros.spin_until(lambda: infos)
    for name, text, reason in (
        ('prior.stiffness', '[8.0, -1.0]', 'stiffness: prior standard deviation -1.0 is not posit'),
        ('prior.stiffness', '[80.0, 1.0]', 'stiffness: widen the bounds, or correct the prior'),
        ('prior.stiffness', '[8.0]', 'prior.stiffness must have 2 entries, not 1'),
        ('prior.angle', '[1.0e+200, 1.0]', 'prior.angle must be -1e100 to 1e100 rad, not 1e+200'),
        ('walk.rate', '-0.1', 'walk.rate must be 0 to 1e100 1/sqrt(s), not -0.1'),
        ('walk.rate', '.inf', 'walk.rate must be 0 to 1e100 1/sqrt(s), not inf'),
    ):
        answer = asked(ros, name, text)
        assert not answer.successful and answer.reason.startswith(reason), answer.reason
    # The model's own walk of 1, taken away, and what is given in its place.
    for name, text in (
        ('prior.stiffness', '[8, 1]'), ('walk.angle', '2'), ('walk.stiffness', '0.0'),
    ):  # fmt: skip
        assert asked(ros, name, text).successful, name
    info = yaml.safe_load(ros.spin_until(lambda: len(infos) > 3 and infos)[-1].data)
    assert info['parameters'][0] == {
        'name': 'stiffness', 'unit': '1', 'bounds': [1.0, 30.0], 'prior': [8.0, 1.0]
    }  # fmt: skip
    assert info['states'][0]['walk'] == 2.0 and info['settings']['walk.stiffness'] == 0.0
    assert node.estimation.observer.model.parameters[0].prior == (8.0, 1.0)


def test_priors_of_observers_that_take_none_are_ignored_with_a_word(ros, capfd):
    ros.start(Estimator, model='observer_form_third_order', observer='rls_luenberger',
              prior__a2=[2.0, 0.1])  # fmt: skip
    assert 'ignored, as there are no such parameters' in capfd.readouterr().err
