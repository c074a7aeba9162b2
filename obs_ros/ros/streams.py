"""The two streams of an estimator, outputs and inputs, from whatever topics they come."""

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial

from rclpy.clock import Clock, ClockType
from rclpy.exceptions import InvalidTopicNameException
from rclpy.node import Node
from rclpy.validate_topic_name import validate_topic_name

from obs_ros.core.model import Model, names
from obs_ros.core.record import Sample
from obs_ros.interface.bindings import HEADER, Binding, bindings, signal_parameters
from obs_ros.interface.readers import NAMED_VECTOR, topic_readers
from obs_ros.interface.sensors import with_sensors
from obs_ros.interface.status import SubscriptionStatus
from obs_ros.ros.guarded import GuardedNode
from obs_ros.ros.message_types import fields_of, message_type
from obs_ros.ros.parameters import Parameters
from obs_ros.ros.subscription import Subscription
from obs_ros.samples.merge import Merge, Role


@dataclass(frozen=True)
class StreamSettings:
    """Wall times by which samples are handed out."""

    budget: float = 0.05  # s that samples take before other callbacks get their turn
    tick: float = 0.25  # of `wait`, after which samples that wait are tried again
    shortest_tick: float = 0.001  # s: with no wait, a timer must not spin


SETTINGS = StreamSettings()


class Streams:
    """Subscribes to what the model needs, and hands out samples in order of stamp, with arrivals.

    Outputs and inputs with a binding come from there, all others by name from plant/output and
    plant/input. All that waits on any topic is read before the oldest of it is handed out, so no
    backlog puts one topic before another; on messages that are still under way samples wait up to
    `wait` s, see `Merge`. The bindings are expected to pass `check_bindings`. Nothing is subscribed
    to before `open`, nor after `close`; `destroy` ends all of it.
    """

    def __init__(
        self,
        node: GuardedNode,
        model: Model,
        bound: Mapping[str, Binding],
        wait: float,
        absorb: Callable[[Sample, float], None],
        settings: StreamSettings = SETTINGS,
    ) -> None:
        self._settings = settings
        self._node = node
        self._bound = bound
        self._roles: dict[Role, Sequence[str]] = {
            'output': names(model.outputs), 'input': names(model.inputs)
        }  # fmt: skip
        self._merged = partial(Merge, wait, absorb)
        self._merge = self._merged()
        self._guard = node.create_guard_condition(self._serve)
        self._timer = node.create_timer(
            max(wait * settings.tick, settings.shortest_tick),
            self._serve,
            clock=Clock(clock_type=ClockType.STEADY_TIME),
        )
        self._timer.cancel()
        self.subscriptions: dict[str, Subscription] = {}

    def open(self) -> None:
        """Subscribe to every topic."""
        for role, entries in self._roles.items():
            default = f'plant/{role}'
            for topic, reader in topic_readers(
                entries, self._bound, default, self._node.resolve_topic_name
            ):
                name = role if topic == default else f'{role}.{topic}'
                self.subscriptions[name] = Subscription(
                    self._node, topic, role, reader, self._merge, self._serve
                )

    def close(self) -> None:
        """Hear nothing any more, and forget the samples that wait."""
        self._timer.cancel()
        for each in self.subscriptions.values():
            each.destroy()
        self.subscriptions.clear()
        self._merge = self._merged()

    def destroy(self) -> None:
        """End it."""
        self.close()
        self._node.destroy_timer(self._timer)
        self._node.destroy_guard_condition(self._guard)

    @property
    def waiting(self) -> int:
        """The number of samples that wait for others."""
        return len(self._merge)

    @property
    def alternating(self) -> bool:
        """Whether publishers of one topic send by turns: no estimate is to be had from those."""
        return any(each.alternating for each in self.subscriptions.values())

    def stale(self, after: float) -> bool:
        """Return whether a topic that was heard has been silent for longer than that (wall s)."""
        return any((each.silence or 0.0) > after for each in self.subscriptions.values())

    def status(self) -> dict[str, SubscriptionStatus]:
        """Return the status of each subscription, by its name in the diagnostics."""
        return {name: each.status() for name, each in self.subscriptions.items()}

    def rest(self) -> None:
        """Count silence from now on, after a pause in which nobody listened."""
        for each in self.subscriptions.values():
            each.rest()

    def clear(self) -> None:
        """Forget the samples that wait."""
        self._merge.clear()

    def _serve(self) -> None:
        """Hand out what is complete; after some time, let other callbacks have their turn."""
        for subscription in self.subscriptions.values():
            subscription.read_waiting()
        end = time.monotonic() + self._settings.budget
        if not self._merge.release(time.monotonic(), lambda: time.monotonic() > end):
            self._guard.trigger()
        if not len(self._merge):
            self._timer.cancel()
        elif self._timer.is_canceled():
            self._timer.reset()


def with_signals(
    node: Node, model: Model, parameters: Parameters
) -> tuple[Model, Mapping[str, Binding]]:
    """Return the model as parameters `signals.<name>` complete it, and what they bind.

    They are declared here. Raises ValueError for those that are wrong.
    """
    parameters.declare(signal_parameters(model))
    bound = bindings(model, parameters.values, parameters.unknown('signals.'))
    check_bindings(node, model, bound)
    return with_sensors(model, parameters.values), bound


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
