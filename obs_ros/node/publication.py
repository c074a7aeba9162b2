"""An estimate as messages."""

from rclpy.node import Node
from sensor_msgs.msg import JointState

from obs_ros.estimate import Estimate
from obs_ros.model import Model
from obs_ros.node.messages import STREAM, named_vector
from obs_ros.vectors import TOPICS, publishable, vectors


class EstimatePublisher:
    """Publishes ~/state, ~/parameters, their standard deviations, ~/jump and ~/solver."""

    def __init__(self, node: Node, model: Model) -> None:
        self._model = model
        self._publishers = {
            topic: node.create_publisher(JointState, f'~/{topic}', STREAM) for topic in TOPICS
        }

    def publish(self, estimate: Estimate, latency: float, skipped: int) -> bool:
        """Publish the estimate, stamped like its newest output; `latency` in s.

        Returns False when values are not finite: they are withheld, and only ~/solver goes out.
        """
        timing = {
            'solve_time_s': estimate.solve_time, 'latency_s': latency, 'skipped': float(skipped),
        }  # fmt: skip
        for topic, stamp, values in vectors(estimate, self._model, timing):
            message = named_vector(stamp, tuple(values), map(float, values.values()))
            self._publishers[topic].publish(message)
        return publishable(estimate)
