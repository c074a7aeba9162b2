"""Nothing that a callback does ends a node, and nothing that fails there goes unseen."""

import functools

import pytest
from diagnostic_msgs.msg import DiagnosticArray
from rcl_interfaces.msg import Parameter, ParameterValue
from rcl_interfaces.srv import SetParameters, SetParametersAtomically
from ros import figures, set_parameter
from sensor_msgs.msg import JointState
from std_srvs.srv import SetBool, Trigger

from obs_ros.interface.status import Health, Level
from obs_ros.ros.diagnostics import publish_health
from obs_ros.ros.estimator import Estimator
from obs_ros.ros.guarded import GuardedNode
from plant_sim.node import Simulator

PROBE = functools.partial(GuardedNode, 'probe')


def fail(*arguments):
    raise KeyError('input\n\x1b[31m' + 1_000_000 * 'x')


def takes_a_message(message):
    fail(message)


def takes_message_and_info(message, info):
    assert 'source_timestamp' in info
    fail(message)


def test_the_nodes_are_guarded():
    assert issubclass(Estimator, GuardedNode) and issubclass(Simulator, GuardedNode)


def test_a_timer_that_fails_goes_on_and_is_told_once(ros, capfd):
    node = ros.start(PROBE)
    node.create_timer(0.01, fail)
    ros.spin_until(lambda: node.failures.count >= 3)
    lines = [line for line in capfd.readouterr().err.splitlines() if 'fail failed' in line]
    (line,) = lines
    assert 'KeyError(' in line and 'the node goes on' in line
    assert len(line) < 400 and line.isprintable()


@pytest.mark.parametrize('callback', [takes_a_message, takes_message_and_info])
def test_a_subscription_that_fails_goes_on(ros, callback):
    node = ros.start(PROBE)
    node.create_subscription(JointState, 'topic', callback, 10)
    send = ros.speak('topic')
    for k in (1, 2):
        send(0.0, ['x'], [1.0])
        ros.spin_until(lambda k=k: node.failures.count == k)


def test_a_guard_condition_that_fails_goes_on(ros):
    node = ros.start(PROBE)
    guard = node.create_guard_condition(fail)
    for k in (1, 2):
        guard.trigger()
        ros.spin_until(lambda k=k: node.failures.count == k)


@pytest.mark.parametrize(('kind', 'fields'), [(Trigger, {}), (SetBool, {'data': True})])
def test_a_service_that_fails_says_so_and_goes_on(ros, kind, fields):
    node = ros.start(PROBE)
    node.create_service(kind, '~/do', lambda *_: fail())
    for _ in range(2):
        answer = ros.call('/probe/do', kind, **fields)
        assert not answer.success and 'failed: KeyError(' in answer.message
    assert node.failures.count == 2


@pytest.mark.parametrize('kind', [SetParameters, SetParametersAtomically])
def test_a_parameter_of_no_known_type_is_refused(ros, kind):
    """rclpy raises in its own service, which would end the node."""
    node = ros.start(PROBE)
    wrong = Parameter(name='x', value=ParameterValue(type=200))
    service = 'set_parameters' + ('_atomically' if kind is SetParametersAtomically else '')
    answer = ros.call(f'/probe/{service}', kind, parameters=[wrong])
    (result,) = getattr(answer, 'results', None) or [answer.result]
    assert not result.successful and '200' in result.reason
    assert node.failures.count == 1


def test_failures_turn_the_level_for_one_message_and_stay_counted(ros):
    node = ros.start(PROBE)
    guard = node.create_guard_condition(fail)
    publish_health(node, lambda: 'x', lambda: Health(Level.OK, 'all is well'))
    assert 'callbacks_failed' not in figures(ros.health())
    guard.trigger()
    ros.spin_until(lambda: node.failures.count)
    status = ros.health()
    assert status.level == status.ERROR
    assert status.message.startswith('fail failed: KeyError(')
    assert status.message.endswith('; all is well') and status.message.isprintable()
    status = ros.health()
    assert (status.level, status.message) == (status.OK, 'all is well')
    assert figures(status)['callbacks_failed'] == '1'
    assert figures(status)['last_failure'].startswith('fail failed: KeyError(')


def unsayable():
    class Unsayable:
        def __str__(self):
            raise RuntimeError('no words')

    return Health(Level.OK, 'fine', {'figure': Unsayable()})


@pytest.mark.parametrize('examine', [fail, unsayable, lambda: None])
def test_diagnostics_that_fail_are_shown_and_end_nothing(ros, capfd, examine):
    node = ros.start(PROBE)
    publish_health(node, lambda: 'x', examine)
    status = ros.health()
    assert status.level == status.ERROR
    assert status.message.startswith('diagnostics failed: ')
    assert len(status.message) < 300 and status.message.isprintable()
    counts = [int(figures(each)['diagnostics_failed']) for each in (status, ros.health())]
    assert counts[1] > counts[0] >= 1
    lines = [line for line in capfd.readouterr().err.splitlines() if 'diagnostics failed' in line]
    assert len(lines) == 1


def test_an_estimator_whose_diagnostics_fail_lives(ros, monkeypatch):
    node = ros.start(Estimator)
    monkeypatch.setattr('obs_ros.ros.estimation.examine', fail)
    assert ros.health().message.startswith('diagnostics failed: KeyError(')
    monkeypatch.undo()
    assert not ros.health(outcome='waiting').message.startswith('diagnostics')
    assert set_parameter(node, 'deadline', 2.0).successful


def test_a_name_of_a_megabyte_makes_no_megabyte_of_diagnostics(ros, capfd):
    """Nor do escape sequences get through, here or to the terminal."""
    ros.start(Estimator)
    arrays = ros.listen('/diagnostics', DiagnosticArray)
    send = ros.speak('plant/output')
    name = 'x\x1b[31m\n' + 1_000_000 * 'y'

    def refused():
        return [a for a in arrays if 'refused' in a.status[0].message]

    send(1.0, [name, 'h2'], [1.0, 2.0])
    (status,) = ros.spin_until(refused)[0].status
    assert figures(status)['output.missing_name'] == '1'
    texts = [status.message, *(text for each in status.values for text in (each.key, each.value))]
    assert sum(map(len, texts)) < 10_000
    assert all(text.isprintable() for text in texts)
    lines = [line for line in capfd.readouterr().err.splitlines() if 'refused' in line]
    assert lines and all(line.isprintable() and len(line) < 1000 for line in lines)


def test_whatever_a_health_says_is_one_short_line(ros):
    nasty = 'x\x1b[31m\n' + 100_000 * 'y'
    publish_health(ros.start(PROBE), lambda: nasty, lambda: Health(Level.OK, nasty, {nasty: nasty}))
    status = ros.health()
    (figure,) = status.values
    for text in (status.message, status.hardware_id, figure.key, figure.value):
        assert text.isprintable() and len(text) <= 2000
