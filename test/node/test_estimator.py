import itertools
import math
from dataclasses import replace

import pytest
import yaml
from diagnostic_msgs.msg import DiagnosticArray
from node.fakes import FakeObserver
from rclpy.parameter import Parameter
from rclpy.qos import QoSProfile, ReliabilityPolicy
from ros import Ros, figures, set_parameter, vector
from rosgraph_msgs.msg import Clock
from std_msgs.msg import String
from std_srvs.srv import SetBool, Trigger

from obs_ros.core.estimate import Jump
from obs_ros.interface.compilation import Children
from obs_ros.ros.estimator import Estimator
from obs_ros.ros.messages import LATCHED, time_message

FAKE = 'node.fakes:FakeObserver'
LEVELS, FEEDS = ('h1', 'h2'), ('Q1', 'Q2')


class Bench:
    """An estimator with a fake observer, due at every second output, and what it says."""

    def __init__(self, ros: Ros, *cli: str, prefix: str = '', **parameters) -> None:
        self.ros = ros
        defaults = {'observer': FAKE, 'window__duration': 2.0}
        self.estimator = ros.start(Estimator, *cli, **{**defaults, **parameters})
        self.fake = FakeObserver.made[-1]
        self.state = ros.listen(f'{prefix}/estimator/state')
        self.parameters = ros.listen(f'{prefix}/estimator/parameters')
        self.state_stddev = ros.listen(f'{prefix}/estimator/state_stddev')
        self.solver = ros.listen(f'{prefix}/estimator/solver')
        self.output = ros.speak(f'{prefix}/plant/output')
        self.input = ros.speak(f'{prefix}/plant/input')
        ros.spin_until(
            lambda: self.estimator.estimation.progress.ready and self.estimator.estimation.idle
        )

    def feed(self, *times: float) -> None:
        for t in times:
            self.input(t, FEEDS, (30, 30))
            self.output(t, LEVELS, (t, t))


@pytest.fixture
def bench(ros):
    return Bench(ros)


def test_estimates_carry_the_stamp_of_the_newest_output(ros, bench):
    bench.feed(10, 11)
    ros.spin_until(lambda: bench.parameters and bench.solver and bench.state_stddev)
    assert vector(bench.parameters[0]) == {'p1': 2.0, 'p2': 2.0, 'p3': 2.0}
    assert vector(bench.state[0]) == {'h1': 2.0, 'h2': 2.0, 'h3': 2.0}
    assert {m[0].header.stamp.sec for m in (bench.state, bench.parameters, bench.solver)} == {11}
    assert vector(bench.state_stddev[0])['h1'] == 0.25
    assert math.isnan(vector(bench.state_stddev[0])['h3'])
    solver = vector(bench.solver[0])
    assert (solver['cost'], solver['evaluations'], solver['skipped']) == (2.0, 7.0, 0.0)
    assert 0.0 <= solver['latency_s'] < 5.0


def test_the_outcome_of_each_estimate_is_told_with_its_stamp(ros, bench):
    bench.feed(10, 11)
    ros.spin_until(lambda: bench.state)
    told = ros.listen('/estimator/outcome', String, LATCHED)  # who comes late hears it, too
    outcome = yaml.safe_load(ros.spin_until(lambda: told)[0].data)
    assert outcome == {'stamp_ns': 11 * 10**9, 'outcome': 'converged', 'message': 'as told'}


def test_jumps_retractions_and_a_drift_are_told_the_drift_once_in_the_log(ros, bench, capfd):
    jumps = ros.listen('/estimator/jump')
    intervals = ros.listen('/estimator/parameters_interval')
    jump = Jump(5.0, 0.1, {'p1': -0.3}, {'p1': 0.01}, True, stamp=5 * 10**9, probability=0.97)
    back = replace(jump, sizes={'p1': 0.0}, stddev={'p1': 0.0}, retracted=True, probability=0.01)
    bench.fake.says = {'jumps': (jump,), 'drifting': ('p2',), 'interval': {'p1': (0.5, 3.0)}}
    bench.feed(10, 11)
    ros.spin_until(lambda: jumps and intervals)
    assert (jumps[0].name, list(jumps[0].position)) == (['p1'], [-0.3])
    assert (list(jumps[0].effort), list(jumps[0].velocity)) == ([0.01], [0.97])
    assert (intervals[0].position[0], intervals[0].velocity[0]) == (0.5, 3.0)
    told = figures(ros.health(outcome='converged'))
    assert told['last_jump'].endswith('p1 -0.3 +- 0.02, probability 0.97')
    assert told['last_jump.probability'] == '0.97'
    bench.fake.says = {'jumps': (back,), 'drifting': ('p2',)}
    bench.feed(12, 13)
    ros.spin_until(lambda: len(jumps) == 2)
    assert list(jumps[1].position) == [0.0] and jumps[1].header == jumps[0].header
    told = figures(ros.health(outcome='converged'))
    assert told['last_retraction'] == 'jump at 5.00 s taken back: p1'
    assert 'last_jump' not in told and told['drifting'].startswith('give it a walk: walk.p2')
    ros.health(outcome='converged')
    assert capfd.readouterr().err.count('give it a walk: walk.p2') == 1


def test_what_only_some_windows_need_waits_for_the_child_that_compiles_it(ros, monkeypatch):
    busy, more = [True], []
    monkeypatch.setattr(Children, 'busy', property(lambda _: busy[0]))
    monkeypatch.setattr(FakeObserver, 'prepare_more', lambda _: more.append(1) or len(more) < 3)
    bench = Bench(ros)
    bench.feed(10, 11)
    ros.spin_until(lambda: bench.state)  # windows need not wait
    assert figures(ros.health())['compiled'] == 'false' and not more
    busy[0] = False
    ros.spin_until(lambda: figures(ros.health())['compiled'] == 'true')
    assert len(more) == 3


def test_messages_are_read_by_name_in_any_order(ros, bench):
    bench.output(1, ('h2', 'h1'), (2, 1))
    ros.spin_until(lambda: bench.fake.outputs)
    assert bench.fake.outputs[0].y.tolist() == [1.0, 2.0]


def test_further_names_are_ignored_and_counted_once_per_message(ros, bench):
    bench.output(1, ('x', 'h2', 'y', 'h1', 'y'), (7, 2, 8, 1, 9))
    bench.output(2, LEVELS, (3, 4))
    bench.output(3, ('h1', 'h2', 'z'), (5, 6, 7))
    ros.spin_until(lambda: len(bench.fake.outputs) == 3)
    assert [sample.y.tolist() for sample in bench.fake.outputs] == [[1, 2], [3, 4], [5, 6]]
    values = figures(ros.health())
    assert values['output.other_names'] == '2' and 'input.other_names' not in values
    assert 'output.last_refusal' not in values


def test_wrong_messages_are_counted_and_named(ros, bench):
    bench.output(1, ('h1', 'h9'), (1, 2))
    bench.output(1, ('h1',), (1,))
    bench.output(1, LEVELS, (1, 2, 3))
    bench.input(1, FEEDS, (1, 2))
    bench.output(1, LEVELS, (math.nan, 2))
    ros.spin_until(lambda: bench.fake.outputs and bench.fake.inputs)
    values = figures(ros.health())
    assert (values['output.missing_name'], values['output.wrong_length']) == ('2', '1')
    assert values['output.received'] == '4' and values['input.received'] == '1'
    assert len(bench.fake.outputs) == 1, "NaN is the window's to count"
    assert 'plant/output' in values['output.last_refusal']


def test_estimates_that_are_not_finite_are_withheld(ros, bench):
    bench.fake.value = math.nan
    bench.feed(1, 2)
    status = ros.health(outcome='diverged')
    assert status.level == status.ERROR and 'withheld' in status.message
    assert figures(status)['withheld'] == '1'
    assert bench.solver and not bench.state and not bench.parameters
    bench.fake.value = 1.0
    bench.feed(3, 4)
    ros.spin_until(lambda: bench.state)


def test_an_exception_in_the_observer_is_told_and_survived(ros, bench):
    bench.fake.value = RuntimeError('no luck today')
    bench.feed(1, 2)
    status = ros.health(outcome='failed')
    assert status.level == status.ERROR and 'no luck today' in status.message
    bench.fake.value = None
    bench.feed(3, 4)
    ros.spin_until(lambda: bench.state)
    assert figures(ros.health(outcome='converged'))['failed'] == '1'


def test_callbacks_run_on_while_it_solves_and_windows_do_not_queue_up(ros, bench):
    bench.fake.go.clear()
    bench.feed(*range(1, 9))
    ros.spin_until(lambda: len(bench.fake.outputs) == 8)
    assert not bench.state
    bench.fake.go.set()
    ros.spin_until(lambda: len(bench.state) == 2)
    # The window that was being solved, and the newest; the two between are gone.
    assert [m.header.stamp.sec for m in bench.state][1] == 8
    bench.feed(9, 10)
    ros.spin_until(lambda: len(bench.state) == 3)


def test_reset_drops_what_is_being_solved(ros, bench):
    bench.fake.go.clear()
    bench.feed(1, 2)
    ros.spin_until(lambda: bench.estimator.estimation.lag is not None)
    assert ros.call('/estimator/reset', Trigger).success
    assert bench.fake.resets == 1
    bench.fake.go.set()
    bench.feed(11, 12)
    ros.spin_until(lambda: bench.state)
    assert [m.header.stamp.sec for m in bench.state] == [12]


def test_backward_stamps_drop_what_is_being_solved_and_are_named(ros, bench):
    bench.fake.go.clear()
    bench.feed(101, 102)
    ros.spin_until(lambda: bench.estimator.estimation.lag is not None)
    bench.feed(1)
    ros.spin_until(lambda: len(bench.fake.outputs) == 1)
    bench.fake.go.set()
    bench.feed(2)
    ros.spin_until(lambda: bench.state)
    assert [m.header.stamp.sec for m in bench.state] == [2]
    assert 'jumped back' in figures(ros.health())['last_break']


def test_disabled_it_ignores_samples_and_starts_anew_afterwards(ros, bench):
    assert ros.call('/estimator/enable', SetBool, data=False).success
    bench.feed(1, 2)
    status = ros.health(outcome='paused')
    assert status.level == status.WARN
    ros.spin_until(lambda: bench.estimator.estimation.streams.subscriptions['output'].received == 2)
    assert not bench.fake.outputs
    assert ros.call('/estimator/enable', SetBool, data=True).success
    assert bench.fake.resets == 1
    bench.feed(3, 4)
    ros.spin_until(lambda: bench.state)


def test_silent_streams_are_told_first_as_waiting_then_as_stale(ros):
    bench = Bench(ros, stale_after=1)  # an integer where a float is meant
    assert ros.health(outcome='waiting').message.startswith('waiting for plant/output: ')
    bench.feed(1, 2)
    ros.spin_until(lambda: bench.state)
    status = ros.health(outcome='stale_output')
    assert status.level == status.STALE and 'plant/output' in status.message


def test_a_silent_input_is_told_when_the_output_goes_on(ros):
    bench = Bench(ros, stale_after=1.0)
    bench.output(1, LEVELS, (1, 1))
    assert ros.health(outcome='waiting').message.startswith('waiting for plant/input: ')
    bench.input(1, FEEDS, (1, 1))
    times, arrays = itertools.count(2), ros.listen('/diagnostics', DiagnosticArray)

    def stale():
        bench.output(next(times), LEVELS, (1, 1))
        return any('stale_input' in a.status[0].message for a in arrays)

    ros.spin_until(stale)


def test_a_changed_parameter_starts_a_new_observer(ros, bench):
    assert set_parameter(bench.estimator, 'window.duration', 3).successful
    new = FakeObserver.made[-1]
    assert new is not bench.fake and new.duration == 3.0 and isinstance(new.duration, float)
    assert bench.estimator.get_parameter('window.duration').value == 3.0
    ros.spin_until(lambda: bench.estimator.estimation.progress.ready)
    bench.feed(1, 2, 3)
    ros.spin_until(lambda: bench.state)
    assert not bench.fake.outputs and bench.state[0].header.stamp.sec == 3


def test_a_new_deadline_keeps_the_observer(ros, bench):
    assert set_parameter(bench.estimator, 'deadline', 0.25).successful
    assert FakeObserver.made[-1] is bench.fake


@pytest.mark.parametrize(
    ('name', 'value', 'reason'),
    [
        ('window.duration', -1.0, 'window.duration must be 0.001 to 1e9 s, not -1.0'),
        ('window.duration', math.nan, 'window.duration'),
        ('window.duration', 'long', 'Wrong parameter type'),
        ('noise.h1', -0.1, 'noise.h1 must be 0 to 1e100 cm'),
        ('search.method', 'memetik', "did you mean 'memetic'?"),
        ('bounds.p1', [0.1], 'bounds.p1 must have 2 entries'),
        ('seed', 13, 'seed 13 brings bad luck'),
        ('model', 'os:path', 'read-only'),
        ('observer', 'os:path', 'read-only'),
    ],
)
def test_a_wrong_value_is_refused_and_nothing_changes(ros, name, value, reason):
    estimator = ros.start(Estimator, observer=FAKE)
    before, fake = estimator.get_parameter(name).value, FakeObserver.made[-1]
    answer = set_parameter(estimator, name, value)
    assert not answer.successful and reason in answer.reason
    assert estimator.get_parameter(name).value == before
    assert FakeObserver.made[-1] is fake or estimator.estimation.observer is fake


def test_several_parameters_change_together_or_not_at_all(ros):
    estimator = ros.start(Estimator, observer=FAKE)
    fake = estimator.estimation.observer
    answer = estimator.set_parameters_atomically(
        [Parameter('window.duration', value=5.0), Parameter('noise.h1', value=-1.0)]
    )
    assert not answer.successful
    assert estimator.estimation.observer is fake
    assert estimator.get_parameter('window.duration').value == 1000.0


def test_parameters_reach_the_observer_as_it_wants_them(ros):
    ros.start(
        Estimator,
        observer=FAKE,
        parameters=['p1'],
        states=['none'],
        bounds__p1=[0, 1],
        bounds__h3=[5.0, 60.0],
        fixed__p2=1,
        noise__h1=0.1,
        search__method='chaotic_de',
        search__population=40,
        window__period=50,
    )
    settings = FakeObserver.made[-1].settings
    assert settings['parameters'] == ('p1',) and settings['states'] == ()
    assert settings['bounds'] == {'h3': (5.0, 60.0)}
    assert settings['fixed'] == {'p2': 1.0} and settings['noise'] == {'h1': 0.1}
    assert settings['search_options'] == {'population': 40} and settings['period'] == 50.0


def test_info_is_there_for_those_who_come_late(ros, bench):
    texts = ros.listen('/estimator/info', String, LATCHED)
    info = yaml.safe_load(ros.spin_until(lambda: texts)[0].data)
    assert info['model'] == 'three_tank' and info['settings']['window.duration'] == 2.0
    assert [v['name'] for v in info['states']] == ['h1', 'h2', 'h3']
    assert info['parameters'][0] == {'name': 'p1', 'unit': '1', 'bounds': [0.0, 1.0]}


def test_namespaces_and_remaps(ros):
    bench = Bench(
        ros, '--ros-args', '-r', '__ns:=/cell', '-r', 'plant/output:=plant/output', prefix='/cell'
    )
    bench.feed(1, 2)
    ros.spin_until(lambda: bench.state)


def test_best_effort_publishers_are_heard(ros):
    estimator = ros.start(Estimator, observer=FAKE)
    publisher = ros.speak('/plant/output', QoSProfile(depth=5))
    unsure = QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT)
    unsure_publisher = ros.speak('/plant/output', unsure)
    fake, times = estimator.estimation.observer, itertools.count(1)

    def heard():
        unsure_publisher(next(times), LEVELS, (7, 7))
        return fake.outputs

    ros.spin_until(heard)
    count = len(fake.outputs)
    publisher(next(times), LEVELS, (8, 8))
    ros.spin_until(lambda: any(s.y[0] == 8.0 for s in fake.outputs[count:]))


def test_a_backward_jump_of_ros_time_resets(ros):
    estimator = ros.start(Estimator, observer=FAKE, use_sim_time=True)
    clock = ros.node.create_publisher(Clock, '/clock', 10)
    ros.spin_until(clock.get_subscription_count)
    for seconds in (100, 50):
        clock.publish(Clock(clock=time_message(seconds * 10**9)))
        ros.spin_until(lambda s=seconds: estimator.get_clock().now().nanoseconds == s * 10**9)
    assert estimator.estimation.observer.resets == 1


def test_it_can_start_again_in_the_same_process(ros):
    Bench(ros)
    again = Ros()
    try:
        bench = Bench(again)
        bench.feed(1, 2)
        again.spin_until(lambda: bench.state)
    finally:
        again.close()


@pytest.mark.parametrize(
    ('parameters', 'reason'),
    [
        ({'model': 'three_tnak'}, "unknown model 'three_tnak': did you mean 'three_tank'?"),
        ({'observer': 'sliding_windw'}, "did you mean 'sliding_window'?"),
        ({'parameters': ['p9']}, 'p9'),
        ({'bounds__p1': [0.9, 0.1]}, 'p1'),
        ({'noise__h1': -1.0}, 'noise.h1'),
        ({'window__duration': 'long'}, "window.duration must be a number, not 'long'"),
    ],
)
def test_wrong_values_at_start(ros, parameters, reason):
    with pytest.raises(ValueError) as caught:
        ros.start(Estimator, **parameters)
    assert reason in str(caught.value)
