"""The estimator as a managed node, sent from state to state by the services of its lifecycle."""

import os
import signal
import subprocess
import sys

import numpy as np
import pytest
from lifecycle_msgs.msg import Transition, TransitionEvent
from lifecycle_msgs.srv import ChangeState, GetAvailableTransitions, GetState
from node.fakes import FakeObserver
from patience import patience
from plants import tank_outputs
from ros import entities, figures, set_parameter, solvers
from std_srvs.srv import SetBool, Trigger

from obs_ros.ros.estimator import Estimator
from obs_ros.ros.fleet import Fleet
from obs_ros.ros.streams import Streams

FAKE = 'node.fakes:FakeObserver'
LEVELS, FLOWS = ('h1', 'h2'), ('Q1', 'Q2')
WAY = {
    'configure': 'inactive', 'activate': 'active', 'deactivate': 'inactive',
    'cleanup': 'unconfigured', 'shutdown': 'finalized',
}  # fmt: skip


class Managed:
    """A managed estimator, and whoever manages it."""

    def __init__(self, ros, *way, name='/estimator', **parameters):
        self.ros, self.name = ros, name
        defaults = {'observer': FAKE, 'window__duration': 2.0}
        self.node = ros.start(Estimator, managed=True, **{**defaults, **parameters})
        assert all(self.go(label) for label in way)

    def go(self, label):
        return go(self.ros, label, self.name)

    @property
    def state(self):
        return self.ros.call(f'{self.name}/get_state', GetState).current_state.label

    @property
    def listens(self):
        return {
            topic for topic in ('/plant/output', '/plant/input')
            if self.node.count_subscribers(topic)
        }  # fmt: skip

    def feed(self, *times):
        output, inputs = self.ros.speak('/plant/output'), self.ros.speak('/plant/input')
        for t in times:
            inputs(t, FLOWS, (30, 30))
            output(t, LEVELS, (t, t))


def go(ros, label, name='/estimator'):
    return ros.call(f'{name}/change_state', ChangeState, transition=Transition(label=label)).success


def test_it_does_in_each_state_what_is_due_there_and_says_which(ros):
    managed = Managed(ros)
    events = ros.listen('/estimator/transition_event', TransitionEvent)
    for label, state in {'': 'unconfigured', **WAY}.items():
        if label:
            assert managed.go(label)
        assert managed.state == state
        ros.spin_until(lambda state=state: figures(ros.health())['lifecycle'] == state)
        assert managed.listens == (
            {'/plant/output', '/plant/input'} if state == 'active' else set()
        )
        configured = state in ('inactive', 'active')
        assert managed.node.count_publishers('/estimator/state') == configured
        assert (managed.node.estimation is not None) == configured
    ros.spin_until(lambda: events and events[-1].goal_state.label == 'finalized')


def test_it_estimates_while_it_is_active_only(ros):
    managed = Managed(ros, 'configure')
    states = ros.listen('/estimator/state')
    assert managed.go('activate')
    ros.spin_until(lambda: managed.node.estimation.progress.ready)
    managed.feed(1, 2)
    ros.spin_until(lambda: states)
    ros.health(outcome='converged')
    assert managed.go('deactivate')
    assert ros.health(outcome='inactive').level == b'\x01'
    assert managed.node.estimation.idle


def test_deactivated_it_keeps_what_it_has_learned_and_publishes_no_late_estimate(ros):
    managed = Managed(ros, 'configure', 'activate')
    estimation, fake = managed.node.estimation, FakeObserver.made[-1]
    ros.spin_until(lambda: estimation.progress.ready and estimation.idle)
    states = ros.listen('/estimator/state')
    fake.go.clear()
    managed.feed(1, 2)
    ros.spin_until(lambda: estimation.lag is not None)
    assert managed.go('deactivate')
    fake.go.set()
    ros.spin_until(lambda: estimation.idle)
    assert managed.go('activate') and managed.node.estimation is estimation
    managed.feed(11, 12)
    ros.spin_until(lambda: states)
    assert [m.header.stamp.sec for m in states] == [12]
    assert len(fake.outputs) == 4 and not fake.resets


def test_cleaned_up_it_forgets_and_keeps_parameters_that_were_changed(ros):
    managed = Managed(ros, 'configure', 'activate')
    before = managed.node.estimation.observer
    assert set_parameter(managed.node, 'bounds.h3', [1.0, 50.0]).successful
    assert managed.go('deactivate') and managed.go('cleanup') and managed.go('configure')
    after = managed.node.estimation.observer
    assert after is not before and not after.outputs
    assert after.settings['bounds'] == {'h3': (1.0, 50.0)}
    assert after.duration == before.duration == 2.0


@pytest.mark.parametrize('way', [(), ('configure',), ('configure', 'activate')], ids=str)
def test_it_can_be_shut_down_from_every_state(ros, way):
    managed = Managed(ros, *way)
    assert managed.go('shutdown') and managed.state == 'finalized'
    assert managed.node.estimation is None and not managed.listens
    status = ros.health(outcome='finalized')
    assert status.message == 'finalized: start it anew to go on'


MENDED = [
    ({'model': 'three_tnak'}, "did you mean 'three_tank'?", {'model': 'three_tank'}),
    ({'seed': 13}, 'seed 13 brings bad luck', {'seed': 12}),
    ({'window__duration': 'long'}, "must be a number, not 'long'", {'window.duration': 2.0}),
    (
        {'signals__h1__topic': '/l', 'signals__h1__field': 'dat',
         'signals__h1__type': 'std_msgs/msg/Float64', 'signals__h1__stamp': 'arrival'},
        "did you mean 'data'?", {'signals.h1.field': 'data'},
    ),
    ({'signals__h9__topic': '/l'}, "no output or input 'h9'", {'signals.h9.topic': None}),
    ({'signals__h1__topic': '/l'}, 'signals.h1.type is not', {'signals.h1.topic': ''}),
]  # fmt: skip


@pytest.mark.parametrize(('given', 'reason', 'mended'), MENDED, ids=lambda each: str(each)[:24])
def test_a_configure_that_fails_says_why_and_a_later_one_with_mended_values_works(
    ros, capfd, given, reason, mended
):
    threads, managed = solvers(), Managed(ros, **given)
    before = entities(managed.node)
    for _ in range(2):
        assert not managed.go('configure') and managed.state == 'unconfigured'
        assert entities(managed.node) == before
    ros.spin_until(lambda: not solvers() - threads)
    assert reason in capfd.readouterr().err
    status = ros.health(outcome='unconfigured')
    assert status.level == status.ERROR and reason in status.message
    for name, value in mended.items():
        answer = set_parameter(managed.node, name, value)
        assert answer.successful, answer.reason
    assert managed.go('configure') and managed.go('activate')
    assert managed.state == 'active'


def test_repeated_cycles_leave_nothing_behind(ros):
    threads, managed = solvers(), Managed(ros)
    cycle = [label for label in WAY if label != 'shutdown']
    assert all(managed.go(label) for label in cycle)  # what rclpy makes once is made now
    ros.spin_until(lambda: not solvers() - threads)
    before, names = entities(managed.node), {*managed.node.get_parameters_by_prefix('')}
    for _ in range(5):
        assert all(managed.go(label) for label in cycle)
        assert entities(managed.node) == before
        assert {*managed.node.get_parameters_by_prefix('')} == names
    ros.spin_until(lambda: not solvers() - threads)


def test_activated_and_deactivated_again_and_again_it_listens_once(ros):
    threads, managed = solvers(), Managed(ros, 'configure', 'activate')
    before = entities(managed.node)
    for _ in range(5):
        assert managed.go('deactivate') and managed.go('activate')
        assert entities(managed.node) == before
    ros.spin_until(lambda: len(solvers() - threads) == 1)


def test_it_estimates_what_an_unmanaged_node_does(ros):
    settings = {
        'window__duration': 30.0, 'observer': 'sliding_window', 'deadline': 600.0,
        'learn_noise': False, 'prediction__enabled': False, 'search__population': 20,
    }  # fmt: skip
    managed = Managed(ros, 'configure', 'activate', **settings)
    remaps = '__ns:=/alone', 'plant/output:=/plant/output', 'plant/input:=/plant/input'
    cli = [word for remap in remaps for word in ('-r', remap)]
    alone = ros.start(Estimator, '--ros-args', *cli, **settings)
    told = [
        (ros.listen(f'{name}/parameters'), ros.listen(f'{name}/parameters_stddev'))
        for name in ('/estimator', '/alone/estimator')
    ]
    ros.spin_until(
        lambda: all(n.estimation.progress.ready for n in (managed.node, alone)), timeout=60.0
    )
    output, inputs = ros.speak('/plant/output'), ros.speak('/plant/input')
    ros.spin_until(lambda: managed.node.count_subscribers('/plant/output') == 2)
    levels = tank_outputs(np.arange(62.0), (20.0, 10.0, 15.0), (0.7, 0.6, 0.5))
    levels += 0.05 * np.random.default_rng(1).standard_normal(levels.shape)
    for k, y in enumerate(levels):
        inputs(k, FLOWS, (30.0, 30.0))
        output(k, LEVELS, y)
        if k in (31, 61):
            windows = k // 30
            ros.spin_until(
                lambda n=windows: all(len(each) == n for pair in told for each in pair),
                timeout=60.0,
            )
    one, other = told
    for mine, theirs in zip(one, other):
        assert [m.position.tobytes() for m in mine] == [m.position.tobytes() for m in theirs]
        assert [m.header for m in mine] == [m.header for m in theirs]
    assert len({m.position.tobytes() for m in one[0]}) == 2


@pytest.mark.parametrize(
    'asked', [{'label': 'activate'}, {'id': Transition.TRANSITION_ACTIVATE}, {'id': 77}], ids=str
)
def test_a_transition_that_is_none_here_is_refused_with_those_that_are(ros, capfd, asked):
    managed = Managed(ros)
    answer = ros.call('/estimator/change_state', ChangeState, transition=Transition(**asked))
    assert not answer.success and managed.state == 'unconfigured'
    assert 'choose one of configure, shutdown: the node is unconfigured' in capfd.readouterr().err
    possible = ros.call('/estimator/get_available_transitions', GetAvailableTransitions)
    names = {each.transition.label for each in possible.available_transitions}
    assert names == {'configure', 'shutdown'}


def broken(*_):
    raise KeyError('broken')


def test_a_transition_that_fails_half_way_leaves_a_clean_node_that_can_be_configured(
    ros, capfd, monkeypatch
):
    managed = Managed(ros)
    before = entities(managed.node)
    assert managed.go('configure') and managed.go('activate')
    monkeypatch.setattr(Streams, 'open', broken)
    assert managed.go('deactivate') and not managed.go('activate')
    assert managed.state == 'unconfigured' and entities(managed.node) == before
    assert "KeyError('broken')" in capfd.readouterr().err
    assert 'broken' in ros.health(outcome='unconfigured').message
    monkeypatch.undo()
    assert managed.go('configure') and managed.go('activate')


def test_an_activation_that_others_can_mend_leaves_it_inactive(ros, monkeypatch):
    def refuse(streams):
        raise RuntimeError('no more topics')

    managed = Managed(ros, 'configure')
    monkeypatch.setattr(Streams, 'open', refuse)
    assert not managed.go('activate') and managed.state == 'inactive'
    monkeypatch.undo()
    assert managed.go('activate')


def test_enable_and_reset_keep_their_meaning(ros):
    managed = Managed(ros, 'configure')
    fake = FakeObserver.made[-1]
    assert ros.call('/estimator/enable', SetBool, data=False).success
    assert managed.go('activate')
    ros.spin_until(lambda: managed.node.estimation.progress.ready)
    managed.feed(1, 2)
    ros.health(outcome='paused')
    assert not fake.outputs
    assert managed.go('deactivate')
    assert ros.call('/estimator/enable', SetBool, data=True).success
    assert ros.call('/estimator/reset', Trigger).success and fake.resets == 2
    states = ros.listen('/estimator/state')
    assert managed.go('activate')
    managed.feed(3, 4)
    ros.spin_until(lambda: states)


def test_structure_is_fixed_while_it_is_configured(ros):
    managed = Managed(ros, 'configure')
    for name, value in (('model', 'jet_engine'), ('observer', 'ekf'), ('signals.h1.topic', '/l')):
        answer = set_parameter(managed.node, name, value)
        assert not answer.successful and 'clean the node up first' in answer.reason
    assert set_parameter(managed.node, 'model', 'three_tank').successful, 'no change'
    assert managed.go('cleanup')
    assert set_parameter(managed.node, 'model', 'jet_engine').successful
    assert managed.go('configure') and managed.node.estimation.model.name == 'jet_engine'


def test_a_fleet_of_managed_plants_waits_for_the_transitions_of_each(ros):
    fleet = ros.start(Fleet, plants=['/a', '/b'], managed=True, observer=FAKE, seed=1)
    for node in fleet.nodes[1:]:
        ros.executor.add_node(node)
    assert go(ros, 'configure', '/a/estimator') and go(ros, 'activate', '/a/estimator')
    assert [each.state for each in fleet.estimators.values()] == ['active', 'unconfigured']
    assert set_parameter(fleet.estimators['/b'], 'seed', 13).successful
    assert not go(ros, 'configure', '/b/estimator')
    ros.spin_until(lambda: 'failing: /b' in told_of(ros, '/fleet'))


def told_of(ros, name):
    status = ros.health()
    return status.message if status.name == name else ''


@pytest.mark.slow
@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize(
    'way', [(), ('configure',), ('configure', 'activate'), ('shutdown',)], ids=str
)
def test_a_signal_ends_it_in_peace_in_every_state(ros, way, number):
    environment = {**os.environ, 'ROS_DOMAIN_ID': str(ros.context.get_domain_id())}
    process = subprocess.Popen(
        [sys.executable, '-m', 'obs_ros.ros.estimator', '--ros-args', '-p', 'managed:=true'],
        env=environment, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    try:
        assert all(go(ros, label) for label in way)
        ros.spin_until(lambda: ros.node.count_publishers('/diagnostics'))
        process.send_signal(number)
        _, stderr = process.communicate(timeout=patience(10.0))
    finally:
        process.kill()
    assert process.returncode == 0 and 'Traceback' not in stderr, stderr
