"""How a node is doing, in a form that knows no ROS."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum


class Level(Enum):
    """The levels of diagnostic_msgs/DiagnosticStatus, by their bytes."""

    OK = b'\x00'
    WARN = b'\x01'
    ERROR = b'\x02'
    STALE = b'\x03'


@dataclass(frozen=True)
class Health:
    """A level, one sentence, and figures by name."""

    level: Level
    message: str
    figures: Mapping[str, object] = field(default_factory=dict)
