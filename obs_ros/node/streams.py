"""The two streams of an estimator, outputs and inputs, from whatever topics they come."""

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager

from rclpy.clock import Clock, ClockType
from rclpy.exceptions import InvalidTopicNameException
from rclpy.node import Node
from rclpy.validate_topic_name import validate_topic_name

from obs_ros.merge import Merge
from obs_ros.model import Model, names
from obs_ros.node.bindings import HEADER, Binding
from obs_ros.node.feed import Feed
from obs_ros.node.message_types import fields_of, message_type
from obs_ros.node.readers import NAMED_VECTOR, topic_readers
from obs_ros.record import Sample
from obs_ros.typing import Array


class Streams:
    """Subscribes to what the model needs, and hands out samples, each stream in order of stamp.

    Outputs and inputs with a binding come from there, all others by name from plant/output and
    plant/input. In a stream of several topics samples wait up to `wait` s for each other. What is
    `bound` is expected to pass `check_bindings`.
    """

    def __init__(
        self,
        node: Node,
        model: Model,
        bound: Mapping[str, Binding],
        wait: float,
        absorb: Callable[[Sample], None],
    ) -> None:
        self._node = node
        self._wait = wait
        self._merges: list[Merge] = []
        inputs, outputs = names(model.inputs), names(model.outputs)
        # Inputs first: of messages that wait, they are then read first.
        feeds = [
            *self._subscribe('input', inputs, bound, lambda t, u: absorb(Sample(t, u=u))),
            *self._subscribe('output', outputs, bound, lambda t, y: absorb(Sample(t, y=y))),
        ]
        self.feeds = dict(reversed(feeds))
        if self._merges and wait:
            node.create_timer(wait, self._release, clock=Clock(clock_type=ClockType.STEADY_TIME))

    def clear(self) -> None:
        """Forget the samples that wait."""
        for merge in self._merges:
            merge.clear()

    def _subscribe(
        self,
        stream: str,
        entries: Sequence[str],
        bound: Mapping[str, Binding],
        take: Callable[[int, Array], None],
    ) -> list[tuple[str, Feed]]:
        """Return the feeds of a stream, each with its name in the diagnostics."""
        default = f'plant/{stream}'
        readers = topic_readers(entries, bound, default, self._node.resolve_topic_name, self._now)
        if not any(name in bound for name in entries):
            return [(stream, Feed(self._node, topic, reader, take)) for topic, reader in readers]
        merge = Merge(len(entries), self._wait, take)
        self._merges.append(merge)

        def put(stamp: int, values: Array) -> None:
            merge.add(stamp, values, time.monotonic())

        return [
            (
                stream if topic == default else f'{stream}.{topic}',
                Feed(self._node, topic, reader, put),
            )
            for topic, reader in readers
        ]

    def _now(self) -> int:
        return int(self._node.get_clock().now().nanoseconds)

    def _release(self) -> None:
        for merge in self._merges:
            merge.release(time.monotonic())


def check_bindings(node: Node, model: Model, bound: Mapping[str, Binding]) -> None:
    """Raise ValueError unless every binding has a topic, a type and a field that can be."""
    # By topic: who named it first, with which type and stamp.
    seen = {
        node.resolve_topic_name(f'plant/{stream}'): (f'plant/{stream}', NAMED_VECTOR, HEADER)
        for stream, group in (('input', model.inputs), ('output', model.outputs))
        if any(name not in bound for name in names(group))
    }
    for binding in bound.values():
        name = f'signals.{binding.name}'
        with _blaming(f'{name}.topic'):
            validate_topic_name(binding.topic)
        with _blaming(f'{name}.type'):
            message_type(binding.type)
        with _blaming(f'{name}.field'):
            binding.path.check(binding.type, fields_of)
        fields = fields_of(binding.type)
        if binding.stamp == HEADER and fields.get('header') != 'std_msgs/Header':
            raise ValueError(
                f"{name}.stamp: {binding.type} has no header with a stamp; set it to 'arrival' to "
                'take the time at which messages arrive'
            )
        topic = node.resolve_topic_name(binding.topic)
        other, *those = seen.setdefault(topic, (name, binding.type, binding.stamp))
        if those != [binding.type, binding.stamp]:
            raise ValueError(
                f'{name} and {other} are one topic, {topic}, with different types or stamps: '
                f'{binding.type} by {binding.stamp}, {those[0]} by {those[1]}'
            )


@contextmanager
def _blaming(parameter: str) -> Iterator[None]:
    try:
        yield
    except (ValueError, InvalidTopicNameException) as error:
        raise ValueError(f'{parameter}: {error}') from None
