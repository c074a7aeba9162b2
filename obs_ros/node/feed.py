"""One subscribed topic: its messages read, checked and counted."""

import time
from collections import Counter
from collections.abc import Callable
from typing import Any

from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.qos import QoSProfile

from obs_ros.node.message_types import message_type
from obs_ros.node.messages import STREAM, STREAM_BEST_EFFORT
from obs_ros.node.readers import Reader, WrongMessageError
from obs_ros.typing import Array

_BATCH = 500  # messages read before other callbacks get their turn


class Feed:
    """Hands each vector that `reader` finds on `topic` to `take(stamp in ns, values)`.

    Wrong messages are counted, and named now and then.

    It asks for reliable delivery, and settles for best effort when a publisher offers no more.
    """

    def __init__(
        self, node: Node, topic: str, reader: Reader, take: Callable[[int, Array], None]
    ) -> None:
        self.topic = topic
        self.received = 0
        self.refused: Counter[str] = Counter()
        self.last_refusal = ''
        self._refused_last = False
        self._node = node
        self._reader = reader
        self._take = take
        self._arrival: float | None = None
        self._rate_since = (time.monotonic(), 0)
        self._subscribe(STREAM)

    @property
    def silence(self) -> float | None:
        """Wall time since the last right message in s; None before the first."""
        return None if self._arrival is None else time.monotonic() - self._arrival

    @property
    def refuses(self) -> bool:
        """Whether the last message was refused."""
        return self._refused_last

    def rate(self) -> float:
        """Return the messages per s of wall time since the last call."""
        (since, before), now = self._rate_since, time.monotonic()
        self._rate_since = now, self.received
        return (self.received - before) / max(now - since, 1e-9)

    def rest(self) -> None:
        """Count silence from now on, after a pause in which nobody listened."""
        if self._arrival is not None:
            self._arrival = time.monotonic()

    def _subscribe(self, qos: QoSProfile) -> None:
        self._subscription = self._node.create_subscription(
            message_type(self._reader.type),
            self.topic,
            self._drain,
            qos,
            event_callbacks=SubscriptionEventCallbacks(incompatible_qos=self._settle),
        )

    def _settle(self, _: object) -> None:
        self._node.get_logger().warning(
            f'{self._subscription.topic_name}: a publisher offers best effort only; '
            'messages may get lost'
        )
        self._node.destroy_subscription(self._subscription)
        self._subscribe(STREAM_BEST_EFFORT)

    def _drain(self, message: Any) -> None:
        """Read the message, and those waiting behind it: a turn of the executor costs far more."""
        subscription = self._subscription
        self._read(message)
        with subscription.handle:
            for _ in range(_BATCH):
                taken = subscription.handle.take_message(subscription.msg_type, subscription.raw)
                if taken is None:
                    break
                self._read(taken[0])

    def _read(self, message: Any) -> None:
        self.received += 1
        try:
            stamp, values = self._reader.read(message)
        except WrongMessageError as error:
            self.refused[error.reason] += 1
            self._refused_last = True
            self.last_refusal = f'{self.topic}: {error}'
            self._node.get_logger().warning(
                f'message refused: {self.last_refusal}', throttle_duration_sec=5.0
            )
            return
        self._arrival, self._refused_last = time.monotonic(), False
        self._take(stamp, values)
