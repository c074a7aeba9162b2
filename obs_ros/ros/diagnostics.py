"""Health of a node, on /diagnostics once a second and in its log."""

from collections.abc import Callable, Mapping

import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.clock import Clock, ClockType
from rclpy.node import Node

from obs_ros.core.texts import one_line
from obs_ros.interface.status import Health, Level
from obs_ros.ros.guarded import Failures, GuardedNode

PERIOD = 1.0  # s, as diagnostic tools expect


def publish_health(
    node: GuardedNode, hardware: Callable[[], str], examine: Callable[[], Health]
) -> None:
    """Publish what `examine` returns, every second of wall time: simulated time may stand still.

    `hardware` returns what it is about: the plant, where the node knows it.
    An `examine` that raises is shown instead of its findings, and so is a callback of the node that
    failed since the last time. Texts are in printable characters, and short.
    """
    publisher = node.create_publisher(DiagnosticArray, '/diagnostics', 10)
    examinations = Failures()

    def found() -> Health:
        try:
            health = examine()
            # A figure that cannot be shown has to fail here.
            health = Health(health.level, health.message, _texts(health.figures))
        except Exception as error:
            # While ROS shuts down whatever is under way may fail.
            if rclpy.ok(context=node.context) and examinations.add('diagnostics', error):
                node.get_logger().error(f'{examinations.last}; the node goes on')
            health = Health(Level.ERROR, examinations.last)
        figures = dict(health.figures)
        if examinations.count:
            figures['diagnostics_failed'] = str(examinations.count)
        if node.failures.count:
            figures |= {
                'callbacks_failed': str(node.failures.count),
                'last_failure': node.failures.last,
            }
        if node.failures.news():
            message = f'{node.failures.last}; {health.message}'
            return Health(Level.ERROR, message, figures)
        return Health(health.level, health.message, figures)

    def publish() -> None:
        health = found()
        status = DiagnosticStatus(
            level=health.level.value,
            name=node.get_fully_qualified_name(),
            message=one_line(health.message),
            hardware_id=one_line(hardware()),
            values=[KeyValue(key=one_line(k), value=str(v)) for k, v in health.figures.items()],
        )
        message = DiagnosticArray(status=[status])
        message.header.stamp = node.get_clock().now().to_msg()
        publisher.publish(message)

    node.create_timer(PERIOD, publish, clock=Clock(clock_type=ClockType.STEADY_TIME))


def log(node: Node, level: Level, line: str) -> None:
    """Write one short line to the node's log: information if all is well, else a warning."""
    # rclpy holds every line of code to one severity.
    if level is Level.OK:
        node.get_logger().info(one_line(line))
    else:
        node.get_logger().warning(one_line(line))


def _texts(figures: Mapping[str, object]) -> dict[str, str]:
    return {name: one_line(_text(value)) for name, value in figures.items()}


def _text(value: object) -> str:
    if isinstance(value, float):
        return f'{value:.6g}'
    return str(value).lower() if isinstance(value, bool) else str(value)
