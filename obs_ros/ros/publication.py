"""An estimate as messages."""

import json
from collections.abc import Mapping
from copy import copy

from rclpy.node import Node
from sensor_msgs.msg import JointState
from std_msgs.msg import String

from obs_ros.core.estimate import Estimate
from obs_ros.core.model import Model
from obs_ros.interface.vectors import TOPICS, publishable, vectors
from obs_ros.ros.messages import LATCHED, OVERRIDABLE, STREAM, named_vector


class EstimatePublisher:
    """Publishes ~/state, ~/parameters, their standard deviations, ~/jump, ~/solver and ~/outcome.

    And ~/prediction, with `predicting`.
    """

    def __init__(self, node: Node, model: Model, *, predicting: bool) -> None:
        self._model = model
        self._publishers = {
            topic: node.create_publisher(
                JointState, f'~/{topic}', copy(STREAM), qos_overriding_options=OVERRIDABLE
            )
            for topic in (*TOPICS, *(('prediction',) if predicting else ()))
        }
        self._outcome = node.create_publisher(String, '~/outcome', LATCHED)

    def publish_prediction(self, stamp: int, state: Mapping[str, float]) -> None:
        """Publish the states at `stamp` (ns)."""
        message = named_vector(stamp, tuple(state), state.values())
        self._publishers['prediction'].publish(message)

    def publish(self, estimate: Estimate, latency: float, skipped: int) -> bool:
        """Publish the estimate, stamped like its newest output; `latency` in s.

        Returns False when values are not finite: they are withheld, and only ~/solver and ~/outcome
        go out, the latter first.
        """
        summary = {
            'stamp_ns': estimate.stamp, 'outcome': estimate.outcome.value,
            'message': estimate.message,
        }  # fmt: skip
        self._outcome.publish(String(data=json.dumps(summary, ensure_ascii=False)))
        timing = {
            'solve_time_s': estimate.solve_time, 'latency_s': latency, 'skipped': float(skipped),
        }  # fmt: skip
        for topic, stamp, values in vectors(estimate, self._model, timing):
            message = named_vector(stamp, tuple(values), map(float, values.values()))
            self._publishers[topic].publish(message)
        return publishable(estimate)
