"""The live page's node: it finds estimators, hears their topics, and serves what it has heard."""

import sys
from collections.abc import Callable, Collection, Mapping
from functools import partial
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.clock import Clock, ClockType
from rclpy.qos import QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import JointState
from std_msgs.msg import String

from obs_ros.core.texts import listing, one_line
from obs_ros.interface.readers import nanoseconds
from obs_ros.interface.sequence_monitor import SequenceMonitor
from obs_ros.interface.vectors import TOPICS, Vector
from obs_ros.pages.board import SETTINGS, Board, BoardSettings
from obs_ros.pages.information import MOST_NAMES, Information, concluded, information
from obs_ros.pages.page import page
from obs_ros.pages.server import PageServer
from obs_ros.pages.settings import VIEW, wanted
from obs_ros.ros.guarded import GuardedNode
from obs_ros.ros.lean_middleware import lean_middleware
from obs_ros.ros.messages import LATCHED
from obs_ros.ros.paced_executor import PacedExecutor
from obs_ros.ros.parameters import Parameters, given_at_start
from obs_ros.ros.publication import PREDICTED
from obs_ros.ros.run import run

LOOK = 0.5  # s from one look at the graph to the next
# Of whatever reliability publishers are: nobody waits for the page; what it misses is told.
STREAMS = QoSProfile(depth=1000, reliability=ReliabilityPolicy.BEST_EFFORT)
RARE = QoSProfile(depth=100, reliability=ReliabilityPolicy.RELIABLE)
MOST_TOPICS = 2 * MOST_NAMES  # of a plant: one for each input and output that is shown
VECTOR = 'sensor_msgs/msg/JointState'
TRUTH = {'state': 'true_state', 'parameters': 'true_parameters'}


class View(GuardedNode):
    """Serves the page of all estimators that are found by their ~/info, on `server.address`.

    It publishes nothing and calls nobody. Raises ValueError when it cannot listen.
    """

    def __init__(self, settings: BoardSettings = SETTINGS, **options: Any) -> None:
        super().__init__('view', automatically_declare_parameters_from_overrides=True, **options)
        parameters = Parameters(self, given_at_start(self))
        parameters.declare(VIEW)
        parameters.watch(lambda values: values, lambda values: None)
        self._wanted, self._most = parameters.values['estimators'], settings.most
        self.board = Board(settings)
        self._heard: dict[str, dict[str, Any]] = {}  # subscriptions by topic, by estimator
        self._infos: dict[str, Information] = {}
        self._gone: dict[str, int] = {}  # looks since nobody published, by estimator
        host, port = parameters.values['host'], parameters.values['port']
        try:
            self.server = PageServer(host, port, *page('obs_ros'), self.board.answer)
        except OSError as error:
            self.destroy_node()
            raise ValueError(
                f'give another port, such as -p port:=0, or host: cannot listen on {host}:{port}: '
                f'{one_line(error)}'
            ) from error
        self.create_subscription(DiagnosticArray, '/diagnostics', self._on_health, 10)
        self.create_timer(LOOK, self._look, clock=Clock(clock_type=ClockType.STEADY_TIME))
        print(f'open {self.server.address}', flush=True)

    def close(self) -> bool:
        """End the server."""
        self.server.close()
        return True

    def _look(self) -> None:
        """Look for estimators on the graph, and whether those known are still there."""
        topics = dict(self.get_topic_names_and_types())
        found = [
            topic.removesuffix('/info') for topic, types in topics.items()
            if topic.endswith('/info') and 'std_msgs/msg/String' in types
            and f'{topic.removesuffix("/info")}/solver' in topics
        ]  # fmt: skip
        for name in self._heard:
            there = self.count_publishers(f'{name}/info') > 0
            self._gone[name] = 0 if there else self._gone.get(name, 0) + 1
            self.board.attend(name, present=there)
        left_out = []
        for name in sorted(found):
            if name in self._heard or not wanted(self._wanted, name):
                continue
            if not self.count_publishers(f'{name}/info'):
                continue
            if len(self._heard) < self._most or self._make_room():
                self._attend(name)
            else:
                left_out.append(name)
        self.board.notes = [
            f"Name those to show by -p estimators:=['...']: {self._most} are shown at most, and "
            f'there are {listing(left_out)} too.'
        ] if left_out else []  # fmt: skip
        for name, info in self._infos.items():
            self._find_plant(name, info, topics)

    def _make_room(self) -> bool:
        """Forget the estimator that is gone for the longest; return whether there was one."""
        name = max(self._gone, key=self._gone.__getitem__, default='')
        if not self._gone.get(name):
            return False
        for subscription in self._heard.pop(name).values():
            self.destroy_subscription(subscription)
        del self._gone[name]
        self._infos.pop(name, None)
        self.board.forget(name)
        return True

    def _attend(self, name: str) -> None:
        """Hear what an estimator says of itself, without which nothing else means anything."""
        self._heard[name] = {}
        self._hear(name, f'{name}/info', String, partial(self._on_info, name), LATCHED)

    def _hear_all(self, name: str) -> None:
        """Hear all topics of an estimator, the latched outcome too."""
        self._hear(name, f'{name}/outcome', String, partial(self._on_outcome, name), LATCHED)
        for topic in (*TOPICS, *PREDICTED):
            qos = RARE if topic == 'jump' else STREAMS
            hear_vector = partial(self._on_vector, name, topic)
            self._hear(name, f'{name}/{topic}', JointState, hear_vector, qos)

    def _hear(
        self, name: str, topic: str, kind: type, callback: Callable[[Any], None], qos: QoSProfile
    ) -> None:
        """Hear a topic: with each message all that wait behind it, which costs less than a turn.

        What is lost is counted, but where only the newest message is kept.
        """
        if topic in self._heard[name]:
            return
        numbers = SequenceMonitor(lambda: self.count_publishers(topic))

        def take(message: Any, info: Mapping[str, Any]) -> None:
            before = numbers.lost
            numbers.note(info['publication_sequence_number'])
            if numbers.lost > before and qos.depth > 1:
                self.board.miss(name, numbers.lost - before)
            callback(message)

        def hear(message: Any, info: Mapping[str, Any]) -> None:
            take(message, info)
            handle = subscription.handle
            with handle:
                for _ in range(qos.depth):
                    if (taken := handle.take_message(kind, False)) is None:
                        break
                    take(*taken)

        subscription = self.create_subscription(kind, topic, hear, qos)
        self._heard[name][topic] = subscription

    def _find_plant(self, name: str, info: Information, topics: Mapping[str, Any]) -> None:
        """Hear what the estimator itself hears, and the truth where it is published beside."""
        space, _, node = name.rpartition('/')
        try:
            theirs = dict(self.get_subscriber_names_and_types_by_node(node, space or '/'))
        except RuntimeError:  # it is just ending
            return
        plant = sorted(topic for topic, types in theirs.items() if VECTOR in types)[:MOST_TOPICS]
        if not plant:
            return  # it does not listen yet, or not now
        wanted = {topic: partial(self._on_sample, name, info, topic) for topic in plant}
        for topic in plant:
            if topic.endswith('/output'):
                for stream, meaning in TRUTH.items():
                    other = f'{topic.removesuffix("output")}{stream}'
                    if VECTOR in topics.get(other, ()):
                        wanted[other] = partial(self._on_vector, name, meaning)
        self._leave(name, keep=wanted)
        for topic, hear in wanted.items():
            self._hear(name, topic, JointState, hear, STREAMS)
        self.board.follow(name, ' '.join(plant))

    def _leave(self, name: str, keep: Collection[str] = ()) -> None:
        """Hear no more of an estimator's plant, but for the topics to `keep`."""
        for topic in [*self._heard[name]]:
            if not topic.startswith(f'{name}/') and topic not in keep:
                self.destroy_subscription(self._heard[name].pop(topic))

    def _on_info(self, name: str, message: String) -> None:
        info = information(message.data)
        if self._infos.get(name) != info:
            self._infos[name] = info
            self._leave(name)
        self.board.inform(name, info)
        self._hear_all(name)

    def _on_outcome(self, name: str, message: String) -> None:
        if (told := concluded(message.data)) is not None:
            self.board.conclude(name, *told)

    def _on_vector(self, name: str, topic: str, message: JointState) -> None:
        self.board.hear(name, _vector(topic, message))

    def _on_sample(self, name: str, info: Information, topic: str, message: JointState) -> None:
        """Take outputs or inputs, whichever have the names that a message brings."""
        for meaning, variables, other in (
            ('measured', info.outputs, '/input'), ('applied', info.inputs, '/output'),
        ):  # fmt: skip
            if not topic.endswith(other) and {v.name for v in variables} & set(message.name):
                self.board.hear(name, _vector(meaning, message))

    def _on_health(self, message: DiagnosticArray) -> None:
        for status in message.status:
            self.board.judge(status.name, int.from_bytes(status.level, 'little'), status.message)


def _vector(topic: str, message: JointState) -> Vector:
    values = dict(zip(message.name, message.position, strict=False))
    return Vector(topic, nanoseconds(message.header.stamp), values, message.velocity,
                  message.effort)  # fmt: skip


def main() -> int:
    """Run the page's node as a process."""
    return run('view', _lean, executor=PacedExecutor)


def _lean() -> View:
    with lean_middleware():
        return View()


if __name__ == '__main__':
    sys.exit(main())
