"""How a node is doing, on /diagnostics once a second."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import Enum

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.clock import Clock, ClockType
from rclpy.node import Node

PERIOD = 1.0  # s


class Level(Enum):
    """The levels of DiagnosticStatus."""

    OK = DiagnosticStatus.OK
    WARN = DiagnosticStatus.WARN
    ERROR = DiagnosticStatus.ERROR
    STALE = DiagnosticStatus.STALE


@dataclass(frozen=True)
class Health:
    """A level, one sentence, and figures by name."""

    level: Level
    message: str
    figures: Mapping[str, object] = field(default_factory=dict)


def publish_health(node: Node, hardware_id: str, examine: Callable[[], Health]) -> None:
    """Publish what `examine` finds, every second of wall time: simulated time may stand still."""
    publisher = node.create_publisher(DiagnosticArray, '/diagnostics', 10)

    def publish() -> None:
        health = examine()
        status = DiagnosticStatus(
            level=health.level.value,
            name=node.get_fully_qualified_name(),
            message=health.message,
            hardware_id=hardware_id,
            values=[KeyValue(key=k, value=_text(v)) for k, v in health.figures.items()],
        )
        message = DiagnosticArray(status=[status])
        message.header.stamp = node.get_clock().now().to_msg()
        publisher.publish(message)

    node.create_timer(PERIOD, publish, clock=Clock(clock_type=ClockType.STEADY_TIME))


def _text(value: object) -> str:
    if isinstance(value, float):
        return f'{value:.6g}'
    return str(value).lower() if isinstance(value, bool) else str(value)
