import array
import math

import numpy as np
import pytest
from geometry_msgs.msg import PoseStamped
from node.fakes import FakeObserver
from plants import tank_outputs
from ros import figures, set_parameter, vector
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64, Float64MultiArray

from obs_ros.interface.bindings import signal_parameters
from obs_ros.models import load_model
from obs_ros.ros.estimator import Estimator
from obs_ros.ros.messages import STREAM, named_vector, time_message

FAKE = 'node.fakes:FakeObserver'
JOINTS, FLOAT = 'sensor_msgs/msg/JointState', 'std_msgs/msg/Float64'
TANKS = load_model('three_tank')


def bind(name, topic, kind, field, **more):
    """The parameters of one binding, as `ros.start` takes them."""
    given = {'topic': topic, 'type': kind, 'field': field, **more}
    return {f'signals__{name}__{part}': value for part, value in given.items()}


def speak(ros, topic, kind):
    publisher = ros.node.create_publisher(kind, topic, STREAM)
    ros.spin_until(publisher.get_subscription_count)
    return publisher.publish


def start(ros, *bound, **more):
    parameters = {'observer': FAKE, 'window__duration': 1000.0, **more}
    for binding in bound:
        parameters |= binding
    return ros.start(Estimator, **parameters), FakeObserver.made[-1]


def pose(t, x):
    message = PoseStamped()
    message.header.stamp = time_message(round(t * 1e9))
    message.pose.position.x = float(x)
    return message


def test_fields_of_several_topics_become_one_stream(ros):
    _, fake = start(
        ros,
        bind('h1', '/left/joint_states', JOINTS, 'position[level]', scale=100.0, offset=-2.5),
        bind('h2', '/right/pose', 'geometry_msgs/msg/PoseStamped', 'pose.position.x'),
        bind('Q1', '/left/joint_states', JOINTS, 'effort[pump]'),
        merge_wait=60.0,
    )
    left, right = (
        speak(ros, '/left/joint_states', JointState),
        speak(ros, '/right/pose', PoseStamped),
    )
    for k in range(1, 5):
        message = JointState(name=['pump', 'level'], position=array.array('d', [0.0, 0.1 * k]))
        message.effort = array.array('d', [7.0, 0.0])
        message.header.stamp = time_message(k * 10**9)
        left(message)
    right(pose(2, 5.0))
    right(pose(4, 6.0))
    right(pose(4.5, 7.0))
    rest = ros.speak('/plant/input')
    for k in range(1, 5):
        rest(k, ['Q2'], [3.0])
    ros.spin_until(lambda: len(fake.outputs) == 4 and len(fake.inputs) == 4)
    assert [s.stamp for s in fake.outputs] == [k * 10**9 for k in range(1, 5)], 'the source stamps'
    got = np.array([s.y for s in fake.outputs])
    want = [[7.5, math.nan], [17.5, 5.0], [27.5, math.nan], [37.5, 6.0]]
    np.testing.assert_allclose(got, want, rtol=1e-12)
    assert [s.u.tolist() for s in fake.inputs] == [[7.0, 3.0]] * 4
    assert [s.stamp for s in fake.inputs] == [k * 10**9 for k in range(1, 5)]


def test_what_is_held_back_comes_without_another_message(ros):
    _, fake = start(
        ros, bind('h1', '/one', JOINTS, 'position[0]'), bind('h2', '/two', JOINTS, 'position[0]')
    )
    one = speak(ros, '/one', JointState)
    one(named_vector(10**9, ['any'], [4.0]))
    ros.spin_until(lambda: fake.outputs)
    assert fake.outputs[0].y[0] == 4.0 and math.isnan(fake.outputs[0].y[1])


def test_arrival_is_told_by_the_nodes_clock(ros):
    estimator, fake = start(
        ros,
        bind('h1', '/level', FLOAT, 'data', stamp='arrival'),
        bind('h2', '/levels', 'std_msgs/msg/Float64MultiArray', 'data[2]', stamp='arrival'),
        use_sim_time=True,
    )
    clock = ros.node.create_publisher(Clock, '/clock', 10)
    ros.spin_until(clock.get_subscription_count)
    clock.publish(Clock(clock=time_message(77 * 10**9)))
    ros.spin_until(lambda: estimator.get_clock().now().nanoseconds == 77 * 10**9)
    level, levels = speak(ros, '/level', Float64), speak(ros, '/levels', Float64MultiArray)
    level(Float64(data=2.0))
    levels(Float64MultiArray(data=[0.0, 0.0, 9.0]))
    ros.spin_until(lambda: fake.outputs)
    assert (fake.outputs[0].stamp, fake.outputs[0].y.tolist()) == (77 * 10**9, [2.0, 9.0])


def test_messages_without_the_entry_are_refused_and_named(ros):
    _, fake = start(ros, bind('h1', '/j', JOINTS, 'position[shoulder]'), merge_wait=0.0)
    joints = speak(ros, '/j', JointState)
    joints(named_vector(1, ['elbow', 'shouldr'], [1.0, 2.0]))
    joints(named_vector(2, ['shoulder'], [3.0]))
    ros.spin_until(lambda: fake.outputs)
    assert fake.outputs[0].stamp == 2 and len(fake.outputs) == 1
    values = figures(ros.health())
    assert values['output./j.no_entry'] == '1' and values['output./j.received'] == '2'
    assert "did you mean 'shouldr'" in values['output./j.last_refusal']


def test_joints_that_report_by_turns_are_one_stream(ros):
    _, fake = start(
        ros,
        bind('h1', '/j', JOINTS, 'position[left]'),
        bind('h2', '/j', JOINTS, 'position[right]'),
        merge_wait=60.0,
    )
    joints = speak(ros, '/j', JointState)
    joints(named_vector(5, ['left'], [1.0]))
    joints(named_vector(4, ['right'], [2.0]))
    joints(named_vector(5, ['right'], [3.0]))
    ros.spin_until(lambda: len(fake.outputs) == 2)
    assert [s.stamp for s in fake.outputs] == [4, 5]
    assert fake.outputs[1].y.tolist() == [1.0, 3.0]


def test_a_silent_topic_is_named_as_stale(ros):
    start(
        ros,
        bind('h1', '/one', JOINTS, 'position[0]'), bind('h2', '/two', JOINTS, 'position[0]'),
        stale_after=2.0,
    )  # fmt: skip
    status = ros.health(outcome='waiting')
    assert '/one' in status.message or '/two' in status.message
    for topic in ('/one', '/two'):
        speak(ros, topic, JointState)(named_vector(1, ['x'], [1.0]))
    ros.speak('/plant/input')(1, ['Q1', 'Q2'], [1, 1])
    one = speak(ros, '/one', JointState)

    def stale():
        one(named_vector(1, ['x'], [1.0]))
        return ros.health().message

    ros.spin_until(lambda: '/two' in stale())


def test_a_window_of_two_rates_finds_the_valves(ros):
    """h1 at 1 Hz and h2 at 0.5 Hz, each on a topic of its own."""
    ros.start(
        Estimator,
        **bind('h1', '/h1', JOINTS, 'position[a]', scale=0.01),
        **bind('h2', '/h2', JOINTS, 'position[a]'),
        window__duration=300.0,
        deadline=20.0,
        merge_wait=60.0,
    )
    found = ros.listen('/estimator/parameters')
    one, two = speak(ros, '/h1', JointState), speak(ros, '/h2', JointState)
    feeds = ros.speak('/plant/input')
    t, valves = np.arange(303.0), (0.9, 0.7, 0.8)
    h = tank_outputs(t, (10.0, 5.0, 7.0), valves)
    for k in range(t.size):
        feeds(t[k], ['Q1', 'Q2'], [30.0, 30.0])
        one(named_vector(k * 10**9, ['a'], [100.0 * h[k, 0]]))
        if k % 2 == 0:
            two(named_vector(k * 10**9, ['a'], [h[k, 1]]))
    ros.spin_until(lambda: found, timeout=60.0)
    assert list(vector(found[0]).values()) == pytest.approx(valves, rel=1e-5)


def test_an_immediate_observer_takes_topics_of_two_rates(ros):
    """An EKF: every whole and every partial sample is a step, in order, though batches arrive."""
    estimator = ros.start(
        Estimator,
        **bind('h1', '/h1', JOINTS, 'position[a]'),
        **bind('h2', '/h2', JOINTS, 'position[a]'),
        observer='ekf',
        merge_wait=60.0,
        **dict.fromkeys(('noise__h1', 'noise__h2'), 0.01),
    )
    ros.spin_until(lambda: estimator.estimation.progress.ready, timeout=60.0)
    found = ros.listen('/estimator/state')
    one, two = speak(ros, '/h1', JointState), speak(ros, '/h2', JointState)
    feeds = ros.speak('/plant/input')
    t = np.arange(121.0)
    h = tank_outputs(t, (50.0, 40.0, 45.0), (0.9, 0.7, 0.8))
    feeds(0.0, ['Q1', 'Q2'], [30.0, 30.0])
    ros.spin_until(lambda: estimator.estimation.streams.subscriptions['input'].received)
    for k in range(t.size):
        one(named_vector(k * 10**9, ['a'], [h[k, 0]]))
    ros.spin_until(
        lambda: estimator.estimation.streams.subscriptions['output./h1'].received == t.size
    )
    for k in range(0, t.size, 3):
        two(named_vector(k * 10**9, ['a'], [h[k, 1]]))
    ros.spin_until(lambda: len(found) == t.size)
    assert [m.header.stamp.sec for m in found] == t.tolist()
    last = vector(found[-1])
    assert (last['h1'], last['h2']) == pytest.approx(h[-1], abs=0.05)
    counts = estimator.estimation.observer.counts
    assert counts['late'] == counts['duplicate'] == counts['reset'] == 0


@pytest.mark.parametrize(
    ('binding', 'reason'),
    [
        (bind('h1', '/a', FLOAT, 'dat', stamp='arrival'), "no field 'dat': did you mean 'data'?"),
        (bind('h1', '/a', FLOAT, 'data'), "no header with a stamp; set it to 'arrival'"),
        (bind('h1', '/a', JOINTS, 'positon[0]'), 'signals.h1.field: sensor_msgs/msg/Joint'),
        (bind('h1', '/a', JOINTS, 'position'), 'say which entry'),
        (bind('h1', '/a', JOINTS, '__class__'), 'signals.h1.field'),
        (bind('h1', '/a', 'std_msgs/msg/Float46', 'data'), "did you mean 'Float64' or 'Float32'"),
        (bind('h1', '/a', 'std_msg/msg/Float64', 'data'), "is package 'std_msg' installed?"),
        (bind('h1', '/a', 'os/path', 'data'), "'os/path' is not of the form package/msg/Type"),
        (bind('h1', 'a b', FLOAT, 'data'), 'signals.h1.topic'),
        (bind('h1', '/a', JOINTS, 'position[0]', offset=math.inf), 'signals.h1.offset must be'),
        (bind('h1', '/a', JOINTS, 'position[0]', stamp='now'), "unknown signals.h1.stamp 'now'"),
        (bind('h11', '/a', JOINTS, 'position[0]'), "no output or input 'h11'"),
        ({'signals__h1__topc': '/a'}, "no parameter 'signals.h1.topc': did you mean 'topic'"),
        (
            bind('h1', 'plant/input', FLOAT, 'data', stamp='arrival'),
            'signals.h1 and plant/input are one topic, /plant/input, with different types',
        ),
        (
            bind('h1', '/a', JOINTS, 'position[0]')
            | bind('h2', '/a', FLOAT, 'data', stamp='arrival'),
            'signals.h2 and signals.h1 are one topic, /a, with different types',
        ),
    ],
)  # fmt: skip
def test_what_cannot_be_is_refused_at_start_with_the_nearest_that_can(ros, binding, reason):
    with pytest.raises(ValueError) as caught:
        start(ros, binding)
    assert reason in str(caught.value)


@pytest.mark.parametrize('spec', signal_parameters(TANKS), ids=lambda spec: spec.name)
def test_no_binding_can_be_changed_from_outside(ros, spec):
    estimator, _ = start(ros)
    answer = set_parameter(estimator, spec.name, 1.0 if isinstance(spec.default, float) else 'x')
    assert not answer.successful
    assert spec.coerce(estimator.get_parameter(spec.name).value) == spec.default


def test_a_sensor_is_declared_without_a_topic(ros):
    given = {'resolution': 0.5, 'range': [0.0, 60.0], 'delay': [0.0, 2.0]}
    estimator, observer = start(ros, {f'signals__h1__{k}': v for k, v in given.items()})
    estimation = estimator.estimation
    h1 = estimation.model.outputs[0]
    assert (h1.resolution, h1.range, h1.delay) == (0.5, (0.0, 60.0), (0.0, 2.0))
    assert observer.model == estimation.model and set(estimation.streams.subscriptions) == {
        'output', 'input'
    }  # fmt: skip
