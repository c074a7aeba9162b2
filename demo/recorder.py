"""A node that listens to the plant, its simulated truth and the estimates."""

from collections.abc import Callable, Mapping

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.node import Node
from sensor_msgs.msg import JointState
from std_srvs.srv import SetBool

Vector = Mapping[str, float]
TOPICS = {
    'output': 'plant/output',
    'truth': 'plant/state',
    'true_parameters': 'plant/parameters',
    'state': 'estimator/state',
    'parameters': 'estimator/parameters',
    'state_stddev': 'estimator/state_stddev',
    'parameters_stddev': 'estimator/parameters_stddev',
    'jump': 'estimator/jump',
}
DEPTH = 2000  # messages; nothing may be lost while the screen is written


class Recorder(Node):
    """Keeps every named vector by topic and stamp (ns), and whether the estimator is ready."""

    def __init__(self) -> None:
        super().__init__('demo')
        self.received: dict[str, dict[int, Vector]] = {key: {} for key in TOPICS}
        self.estimator_ready = False
        self.verdict = 'none'  # of the estimator, on itself
        for key, topic in TOPICS.items():
            self.create_subscription(JointState, topic, self._keep(key), DEPTH)
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
            and self.count_subscribers('plant/output') >= 2
            and self.count_subscribers('plant/input') >= 1
        )

    def estimates(self) -> list[int]:
        """Return the stamps (ns) at which estimates, deviations and the truth all came."""
        topics = ('parameters', 'state', 'parameters_stddev', 'state_stddev', 'truth')
        return sorted(set.intersection(*(set(self.received[topic]) for topic in topics)))

    def start_plant(self) -> None:
        """Let the paused simulator run."""
        self._enable.call_async(SetBool.Request(data=True))

    def _keep(self, key: str) -> Callable[[JointState], None]:
        def callback(message: JointState) -> None:
            stamp = message.header.stamp.sec * 10**9 + message.header.stamp.nanosec
            self.received[key][stamp] = dict(zip(message.name, message.position, strict=True))

        return callback

    def _note(self, message: DiagnosticArray) -> None:
        for status in message.status:
            figures = {entry.key: entry.value for entry in status.values}
            if 'ready' in figures:
                self.estimator_ready |= figures['ready'] == 'true'
                self.verdict = status.message
