import contextlib
import functools

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rclpy.executors import ExternalShutdownException
from ros import figures
from rosgraph_msgs.msg import Clock

from obs_ros.interface.status import Health, Level
from obs_ros.ros.diagnostics import PERIOD, publish_health
from obs_ros.ros.guarded import GuardedNode
from obs_ros.ros.messages import time_message

PROBE = functools.partial(GuardedNode, 'probe')


def test_levels_are_those_of_the_message():
    assert {level.name: level.value for level in Level} == {
        name: getattr(DiagnosticStatus, name) for name in ('OK', 'WARN', 'ERROR', 'STALE')
    }


def test_health_goes_out_as_one_status_of_the_node(ros):
    node = ros.start(PROBE, '--ros-args', '-r', '__ns:=/cell')
    before = node.get_clock().now().nanoseconds
    publish_health(node, lambda: 'three_tank', lambda: Health(Level.STALE, 'as told', {'a': 1}))
    arrays = ros.listen('/diagnostics', DiagnosticArray)
    array = ros.spin_until(lambda: arrays)[0]
    (status,) = array.status
    assert status.level == DiagnosticStatus.STALE
    assert (status.name, status.hardware_id) == ('/cell/probe', 'three_tank')
    assert (status.message, figures(status)) == ('as told', {'a': '1'})
    stamp = array.header.stamp.sec * 10**9 + array.header.stamp.nanosec
    assert before <= stamp <= node.get_clock().now().nanoseconds


def test_figures_are_short_texts_in_their_order(ros):
    health = Health(
        Level.OK,
        '',
        {
            'share': 1 / 3,
            'small': 1.23456789e-7,
            'whole': 2.0,
            'nan': float('nan'),
            'count': 1_234_567_890,
            'yes': True,
            'no': False,
            'text': 'A Word',
            'none': None,
        },
    )
    publish_health(ros.start(PROBE), lambda: 'x', lambda: health)
    assert list(figures(ros.health()).items()) == [
        ('share', '0.333333'),
        ('small', '1.23457e-07'),
        ('whole', '2'),
        ('nan', 'nan'),
        ('count', '1234567890'),
        ('yes', 'true'),
        ('no', 'false'),
        ('text', 'A Word'),
        ('none', 'None'),
    ]


def test_every_message_is_examined_anew_though_simulated_time_stands_still(ros):
    node = ros.start(PROBE, use_sim_time=True)
    clock = ros.node.create_publisher(Clock, '/clock', 10)
    ros.spin_until(clock.get_subscription_count)
    clock.publish(Clock(clock=time_message(7 * 10**9)))
    ros.spin_until(lambda: node.get_clock().now().nanoseconds == 7 * 10**9)
    numbers = iter(range(100))
    publish_health(node, lambda: 'x', lambda: Health(Level.OK, str(next(numbers))))
    arrays = ros.listen('/diagnostics', DiagnosticArray)
    ros.spin_until(lambda: len(arrays) == 2, timeout=10.0 * PERIOD)
    first, second = (int(array.status[0].message) for array in arrays)
    assert second == first + 1
    assert [array.header.stamp.sec for array in arrays] == [7, 7]


def test_what_fails_while_ros_shuts_down_is_not_told(ros, capfd):
    asked = []

    def examine() -> Health:
        asked.append(ros.context.try_shutdown())
        raise RuntimeError('the context is invalid')

    publish_health(ros.start(PROBE), lambda: 'x', examine)
    with contextlib.suppress(ExternalShutdownException):
        ros.spin_until(lambda: asked)
    assert asked and 'diagnostics failed' not in capfd.readouterr().err
