"""One subscribed topic: its messages read, checked and counted."""

import time
from collections import Counter
from collections.abc import Callable, Mapping
from copy import copy
from typing import Any

from rclpy.clock import ROSClock
from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.qos import QoSPolicyKind, QoSProfile, ReliabilityPolicy, qos_policy_name_from_kind
from rclpy.qos_overriding_options import QoSOverridingOptions

from obs_ros.interface.field_path import MessageError
from obs_ros.interface.readers import Reader
from obs_ros.interface.sequence_monitor import SequenceMonitor
from obs_ros.interface.status import SubscriptionStatus
from obs_ros.ros.guarded import GuardedNode
from obs_ros.ros.message_types import message_type
from obs_ros.ros.messages import OVERRIDABLE, STREAM
from obs_ros.samples.merge import Merge, Role

RELIABILITY = int(QoSPolicyKind.RELIABILITY)
# Messages read ahead; further ones wait in the middleware, which may drop them.
MOST: int = STREAM.depth


class Subscription:
    """Adds each vector that `reader` finds on the topic called `topic` to the merge.

    When messages have come, `wake` is called; whoever then wants those that wait behind them calls
    `read_waiting`. Wrong messages are counted, and named now and then. Arrival is when the
    middleware received a message, however long it waited to be read.

    It asks for reliable delivery, and settles for best effort when a publisher offers no more.
    """

    def __init__(
        self,
        node: GuardedNode,
        topic: str,
        role: Role,
        reader: Reader,
        merge: Merge,
        wake: Callable[[], None],
    ) -> None:
        self.topic = topic
        self.role = role
        self.received = 0
        self._refused: Counter[str] = Counter()
        self._last_refusal = ''
        self._unheard = ''  # why a publisher is not heard, if one is not
        self.stamp: int | None = None  # of the last right message, ns
        self._numbers = SequenceMonitor(lambda: self.publishers)
        self._refused_last = False
        self._node = node
        self._reader = reader
        self._merge = merge
        self._queue = merge.topic(role, reader.places, whole=reader.whole)
        self._wake = wake
        self._arrival: float | None = None
        self._rate_since = (time.monotonic(), 0)
        self._subscribe(STREAM, OVERRIDABLE)

    @property
    def silence(self) -> float | None:
        """Wall time since the last right message in s; None before the first."""
        return None if self._arrival is None else time.monotonic() - self._arrival

    @property
    def publishers(self) -> int:
        """The number of publishers; one that was killed is counted for some time yet."""
        return self._node.count_publishers(self._subscription.topic_name)

    @property
    def alternating(self) -> bool:
        """Whether several publishers send by turns, so that their samples mix."""
        return self._numbers.alternating and self.publishers > 1

    @property
    def full(self) -> bool:
        """Whether so many messages wait that no more are read ahead."""
        return len(self._queue) >= MOST

    def status(self) -> SubscriptionStatus:
        """Return all that the diagnostics show of it; the rate is that since the last call."""
        (since, before), now = self._rate_since, time.monotonic()
        self._rate_since = now, self.received
        return SubscriptionStatus(
            topic=self.topic,
            role=self.role,
            silence=self.silence,
            stamp=self.stamp,
            received=self.received,
            other_names=self._reader.others,
            rate=(self.received - before) / max(now - since, 1e-9),
            lost=self._numbers.lost,
            refused=dict(self._refused),
            last_refusal=self._last_refusal,
            refuses=self._refused_last,
            publishers=self.publishers,
            alternating=self.alternating,
            reliable=self._subscription.qos_profile.reliability == ReliabilityPolicy.RELIABLE,
            unheard=self._unheard,
        )

    def rest(self) -> None:
        """Count silence from now on, after a pause in which nobody listened."""
        if self._arrival is not None:
            self._arrival = time.monotonic()

    def destroy(self) -> None:
        """Hear nothing any more."""
        self._node.destroy_subscription(self._subscription)

    def _subscribe(self, qos: QoSProfile, overriding: QoSOverridingOptions | None = None) -> None:
        self._subscription = self._node.create_subscription(
            message_type(self._reader.type),
            self.topic,
            self._hear,
            copy(qos),  # the overrides are written into it
            event_callbacks=SubscriptionEventCallbacks(incompatible_qos=self._settle),
            qos_overriding_options=overriding,
        )

    def _settle(self, event: Any) -> None:
        """Ask for less where that helps; else say why a publisher is not heard."""
        kind, topic = event.last_policy_kind, self._subscription.topic_name
        asked = self._subscription.qos_profile
        if kind == RELIABILITY and asked.reliability != ReliabilityPolicy.BEST_EFFORT:
            self._node.get_logger().warning(
                f'{topic}: a publisher offers best effort only; messages may get lost'
            )
            self._node.destroy_subscription(self._subscription)
            asked.reliability = ReliabilityPolicy.BEST_EFFORT
            self._subscribe(asked)
            return
        policy = qos_policy_name_from_kind(kind).lower()
        self._unheard = f'a publisher of {self.topic} is not heard: its QoS {policy} is another'
        self._node.get_logger().warning(self._unheard)

    def read_waiting(self) -> None:
        """Read the messages that wait to be taken: a turn of the executor for each costs more."""
        subscription = self._subscription
        with subscription.handle:
            while not self.full:
                taken = subscription.handle.take_message(subscription.msg_type, subscription.raw)
                if taken is None:
                    break
                self._read(*taken)

    def _hear(self, message: Any, info: Mapping[str, Any]) -> None:
        self._read(message, info)
        self._wake()

    def _read(self, message: Any, info: Mapping[str, Any]) -> None:
        self.received += 1
        self._numbers.note(info['publication_sequence_number'])
        waited, stamp = self._arrived(info['received_timestamp'])
        try:
            stamp, values = self._reader.read(message, stamp)
        except MessageError as error:
            self._refused[error.reason] += 1
            self._refused_last = True
            self._last_refusal = f'{self.topic}: {error}'
            self._node.get_logger().warning(
                f'message refused: {self._last_refusal}', throttle_duration_sec=5.0
            )
            return
        self._arrival, self._refused_last = time.monotonic() - waited, False
        self.stamp = stamp
        self._merge.add(self._queue, stamp, values, self._arrival)

    def _arrived(self, received: int | None) -> tuple[float, int]:
        """Return how long (s) the message waited to be read, and its arrival on the node's clock.

        `received` (ns, system clock) is what the middleware says; some say nothing.
        """
        clock = self._node.get_clock()
        if not received:
            return 0.0, int(clock.now().nanoseconds)
        waited = max(0.0, (time.time_ns() - received) / 1e9)
        simulated = isinstance(clock, ROSClock) and clock.ros_time_is_active
        return waited, int(clock.now().nanoseconds) if simulated else received
