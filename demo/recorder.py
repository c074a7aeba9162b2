"""A node that listens to the plant, its simulated truth and the estimates."""

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import yaml
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.task import Future
from sensor_msgs.msg import JointState
from std_msgs.msg import String
from std_srvs.srv import SetBool

from demo.jumps import Announced, noted
from demo.pacing import runs_on
from obs_ros.core.estimate import normal_intervals

Vector = Mapping[str, float]
Intervals = Mapping[str, tuple[float, float]]
TOPICS = {
    'output': 'plant/output',
    'truth': 'plant/state',
    'true_parameters': 'plant/parameters',
    'state': 'estimator/state',
    'parameters': 'estimator/parameters',
    'state_stddev': 'estimator/state_stddev',
    'parameters_stddev': 'estimator/parameters_stddev',
    'parameters_interval': 'estimator/parameters_interval',
    'jump': 'estimator/jump',
}
PATIENCE = 5.0  # s for the simulator's answer; a machine that stood still may have lost it
DEPTH = 2000  # messages; nothing may be lost while the screen is written
STARVING = ('waiting', 'stale_output', 'stale_input')  # outcomes of an estimator not served
VOUCHED = ('converged', 'at_bound')  # outcomes of estimates that the node stands by


@dataclass(frozen=True)
class Verdict:
    """The estimator's own word on one of its estimates."""

    outcome: str = 'unknown'
    message: str = ''

    @property
    def vouched(self) -> bool:
        """Whether it stands by the numbers."""
        return self.outcome in VOUCHED


class Recorder(Node):
    """Keeps named vectors, intervals, jumps and verdicts by stamp (ns).

    And whether the estimator is ready.
    """

    def __init__(self, **options: Any) -> None:
        super().__init__('demo', **options)
        self.received: dict[str, dict[int, Vector]] = {key: {} for key in TOPICS}
        self.verdicts: dict[int, Verdict] = {}
        self.estimator_ready = self._estimator_starves = False
        self._running, self._asked = False, 0.0
        self._answer: Future | None = None
        self.intervals: dict[int, Intervals] = {}
        self.jumps: dict[int, Announced] = {}
        others = {'parameters_interval': self._keep_interval, 'jump': self._note_jump}
        for key, topic in TOPICS.items():
            callback = others.get(key) or self._keep(key)
            self.create_subscription(JointState, topic, callback, DEPTH)
        latched = QoSProfile(depth=DEPTH, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self.create_subscription(String, 'estimator/outcome', self._judge, latched)
        self.create_subscription(DiagnosticArray, '/diagnostics', self._note, 10)
        self._enable = self.create_client(SetBool, 'simulator/enable')

    @property
    def plant_time(self) -> float:
        """Stamp of the newest true state in s."""
        return max(self.received['truth'], default=0) / 1e9

    @property
    def connected(self) -> bool:
        """Whether the simulator listens, and is listened to by everybody."""
        return (
            self._enable.service_is_ready()
            and self.estimator_ready
            and all(self.count_publishers(topic) for topic in TOPICS.values())
            and self.count_publishers('estimator/outcome') > 0
            and self.count_subscribers('plant/output') >= 2
            and self.count_subscribers('plant/input') >= 1
        )

    def estimates(self) -> list[int]:
        """Return the stamps (ns) of which estimates, their doubts, verdict and truth all came."""
        topics = ('parameters', 'state', 'parameters_stddev', 'state_stddev', 'truth')
        kept = (set(self.received[topic]) for topic in topics)
        return sorted(set(self.verdicts).intersection(self.intervals, *kept))

    def start_plant(self) -> None:
        """Let the paused simulator run."""
        self._let_run(True)

    def pace(self, window: float, period: float) -> None:
        """Hold the plant while estimates, or what is heard here, lag two periods (s) behind it.

        So the estimator misses no window, however busy the machine is. What the simulator does not
        answer it is told again. An estimator that hears nothing and solves nothing has missed some
        samples: the estimate that the plant is held for needs later ones.
        """
        newest = max(self.verdicts, default=0) / 1e9
        run = self._estimator_starves or runs_on(
            self._running, self.plant_time, newest, window, period
        )
        overdue = self._pending is not None and time.monotonic() > self._asked + PATIENCE
        if run != self._running or overdue:
            self._let_run(run)

    @property
    def _pending(self) -> Future | None:
        """What the simulator has not answered."""
        return None if self._answer is None or self._answer.done() else self._answer

    def _let_run(self, run: bool) -> None:
        if pending := self._pending:
            self._enable.remove_pending_request(pending)
        self._running, self._asked = run, time.monotonic()
        self._answer = self._enable.call_async(SetBool.Request(data=run))

    def _keep(self, key: str) -> Callable[[JointState], None]:
        def callback(message: JointState) -> None:
            self.received[key][_stamp(message)] = _named(message, message.position)

        return callback

    def _keep_interval(self, message: JointState) -> None:
        ends = zip(message.position, message.velocity, strict=True)
        self.intervals[_stamp(message)] = dict(zip(message.name, ends, strict=True))

    def _note_jump(self, message: JointState) -> None:
        sizes, deviations = (_named(message, each) for each in (message.position, message.effort))
        noted(self.jumps, _stamp(message), Announced(sizes, deviations, message.velocity[0]))

    def _judge(self, message: String) -> None:
        word = yaml.safe_load(message.data)
        self.verdicts[word['stamp_ns']] = Verdict(word['outcome'], word['message'])

    def _note(self, message: DiagnosticArray) -> None:
        for status in message.status:
            figures = {entry.key: entry.value for entry in status.values}
            if 'ready' in figures:
                self.estimator_ready |= figures['ready'] == 'true'
                self._estimator_starves = (
                    figures['outcome'] in STARVING and figures['solving'] == 'false'
                )


def intervals_of(recorder: Recorder, topic: str, stamp: int) -> Intervals:
    """Return 95 % intervals of the estimates on a topic: published ones, or by deviations."""
    if topic == 'parameters':
        return recorder.intervals[stamp]
    values, deviations = (recorder.received[each][stamp] for each in (topic, f'{topic}_stddev'))
    return normal_intervals(values, deviations)


def _stamp(message: JointState) -> int:
    return int(message.header.stamp.sec * 10**9 + message.header.stamp.nanosec)


def _named(message: JointState, figures: Sequence[float]) -> Vector:
    return dict(zip(message.name, figures, strict=True))
