"""Named vectors as ROS messages: JointState with `header.stamp`, `name` and `position` only."""

from collections.abc import Iterable, Sequence

import numpy as np
from builtin_interfaces.msg import Time
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import JointState

from obs_ros.registry import suggest
from obs_ros.typing import Array

# Deep enough for a few seconds at 1 kHz while the reader is busy; lost samples bias an estimate.
STREAM = QoSProfile(depth=5000, reliability=ReliabilityPolicy.RELIABLE)
STREAM_BEST_EFFORT = QoSProfile(depth=5000, reliability=ReliabilityPolicy.BEST_EFFORT)
LATCHED = QoSProfile(
    depth=1, reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.TRANSIENT_LOCAL
)


class WrongMessageError(ValueError):
    """A message that does not carry the vector asked for; `reason` is short, for counting."""

    def __init__(self, reason: str, text: str) -> None:
        super().__init__(text)
        self.reason = reason


def time_message(stamp: int) -> Time:
    """Return `stamp` (ns) as a message."""
    return Time(sec=stamp // 1_000_000_000, nanosec=stamp % 1_000_000_000)


def nanoseconds(stamp: Time) -> int:
    """Return a message's stamp in ns."""
    return int(stamp.sec * 1_000_000_000 + stamp.nanosec)


def named_vector(stamp: int, names: Sequence[str], values: Iterable[float]) -> JointState:
    """Return the values, by name, as a message stamped `stamp` (ns)."""
    message = JointState(name=list(names), position=list(values))
    message.header.stamp = time_message(stamp)
    return message


class VectorReader:
    """Reads vectors with the entries `names` out of messages that may have them in any order."""

    kind = JointState

    def __init__(self, names: Sequence[str]) -> None:
        self._names = list(names)

    def read(self, message: JointState) -> tuple[int, Array]:
        """Return stamp (ns) and values (len(names),).

        Raises WrongMessageError, its reason one of `wrong_length`, `unknown_name`, `missing_name`.
        """
        stamp = nanoseconds(message.header.stamp)
        names = message.name
        if len(names) != len(message.position):
            raise WrongMessageError(
                'wrong_length', f'{len(names)} names but {len(message.position)} positions'
            )
        values = np.array(message.position)
        if names == self._names:
            return stamp, values
        order = self._order(names)
        return stamp, values[order]

    def _order(self, names: Sequence[str]) -> list[int]:
        for name in names:
            if name not in self._names:
                raise WrongMessageError(
                    'unknown_name', f'unknown name {name!r}: {suggest(name, self._names)}'
                )
        for name in self._names:
            if name not in names:
                raise WrongMessageError('missing_name', f'{name!r} is missing')
        if len(names) != len(self._names):
            raise WrongMessageError('wrong_length', f'a name stands twice: {list(names)}')
        return [names.index(name) for name in self._names]
