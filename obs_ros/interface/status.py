"""Status of a node and of its subscriptions, in plain numbers: no ROS is needed to judge them."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum

from obs_ros.samples.merge import Role


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


@dataclass(frozen=True)
class SubscriptionStatus:
    """A subscribed topic that brings outputs or inputs, at one moment.

    `silence` (s of wall time) has passed since the last right message, whose stamp is `stamp` (ns);
    both are None before the first. `rate` is in messages per s of wall time. `refused` counts wrong
    messages by reason, `last_refusal` is the text of the newest; `refuses`: the last message was
    one. `other_names` counts messages with names that are not wanted. `unheard` says why a
    publisher is not heard, if one is not. `alternating` publishers send by turns; with `reliable`
    delivery lost messages are sent again.
    """

    topic: str
    role: Role
    silence: float | None = None
    stamp: int | None = None
    received: int = 0
    rate: float = 0.0
    lost: int = 0
    refused: Mapping[str, int] = field(default_factory=dict)
    other_names: int = 0
    last_refusal: str = ''
    refuses: bool = False
    publishers: int = 1
    alternating: bool = False
    reliable: bool = True
    unheard: str = ''
