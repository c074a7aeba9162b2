"""Named vectors as ROS messages: JointState with a stamp, names, up to three figures of each."""

from collections.abc import Iterable

from builtin_interfaces.msg import Time
from rclpy.qos import DurabilityPolicy, QoSPolicyKind, QoSProfile, ReliabilityPolicy
from rclpy.qos_overriding_options import QoSOverridingOptions
from sensor_msgs.msg import JointState

# Deep enough for a few seconds at 1 kHz while the reader is busy; lost samples bias an estimate.
STREAM = QoSProfile(depth=5000, reliability=ReliabilityPolicy.RELIABLE)
# Of windows there are some in a second at most; a publisher takes half the memory then.
ESTIMATES = QoSProfile(depth=20, reliability=ReliabilityPolicy.RELIABLE)
# Parameters qos_overrides.<topic>.<...> may change these of every stream.
OVERRIDABLE = QoSOverridingOptions(
    (
        QoSPolicyKind.HISTORY,
        QoSPolicyKind.DEPTH,
        QoSPolicyKind.RELIABILITY,
        QoSPolicyKind.DURABILITY,
    )
)
LATCHED = QoSProfile(
    depth=1, reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.TRANSIENT_LOCAL
)


def time_message(stamp: int) -> Time:
    """Return `stamp` (ns) as a message."""
    return Time(sec=stamp // 1_000_000_000, nanosec=stamp % 1_000_000_000)


def named_vector(
    stamp: int,
    names: Iterable[str],
    values: Iterable[float],
    velocity: Iterable[float] = (),
    effort: Iterable[float] = (),
) -> JointState:
    """Return the values, by name, as the positions of a message stamped `stamp` (ns)."""
    message = JointState(
        name=list(names), position=list(values), velocity=list(velocity), effort=list(effort)
    )
    message.header.stamp = time_message(stamp)
    return message
