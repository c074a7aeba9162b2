"""An estimate as messages."""

import math
from collections.abc import Mapping

from rclpy.node import Node
from sensor_msgs.msg import JointState

from obs_ros.estimate import Estimate
from obs_ros.model import Model, names
from obs_ros.node.messages import STREAM, named_vector


class EstimatePublisher:
    """Publishes ~/state, ~/parameters, their standard deviations, ~/jump and ~/solver."""

    def __init__(self, node: Node, model: Model) -> None:
        self._names = {'state': names(model.states), 'parameters': names(model.parameters)}
        topics = ('state', 'parameters', 'state_stddev', 'parameters_stddev', 'jump', 'solver')
        self._publishers = {
            topic: node.create_publisher(JointState, f'~/{topic}', STREAM) for topic in topics
        }

    def publish(self, estimate: Estimate, latency: float, skipped: int) -> bool:
        """Publish the estimate, stamped like its newest output; `latency` in s.

        Returns False when values are not finite: they are withheld, and only ~/solver goes out.
        """
        stamp = estimate.stamp or 0
        self._send(
            'solver',
            stamp,
            {
                'cost': estimate.cost,
                'residual_rms': estimate.residual_rms,
                'evaluations': estimate.evaluations,
                'solve_time_s': estimate.solve_time,
                'latency_s': latency,
                'skipped': skipped,
                **estimate.figures,
            },
        )
        vectors = {'state': estimate.state, 'parameters': estimate.parameters}
        if not all(math.isfinite(v) for vector in vectors.values() for v in vector.values()):
            return False
        for topic, vector in vectors.items():
            order = self._names[topic]
            self._send(topic, stamp, {name: vector[name] for name in order})
            deviations = {name: estimate.stddev.get(name, math.nan) for name in order}
            self._send(f'{topic}_stddev', stamp, deviations)
        for jump in estimate.jumps:
            if jump.new:
                self._send('jump', jump.stamp or 0, jump.sizes)
        return True

    def _send(self, topic: str, stamp: int, vector: Mapping[str, float]) -> None:
        values = map(float, vector.values())
        self._publishers[topic].publish(named_vector(stamp, tuple(vector), values))
