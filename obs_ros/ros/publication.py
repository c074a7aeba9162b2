"""An estimate as messages."""

import json
from copy import copy

from rclpy.node import Node
from sensor_msgs.msg import JointState
from std_msgs.msg import String

from obs_ros.core.estimate import Estimate
from obs_ros.core.model import Model
from obs_ros.horizon.prediction import Predicted
from obs_ros.interface.vectors import TOPICS, publishable, vectors
from obs_ros.ros.messages import ESTIMATES, LATCHED, OVERRIDABLE, STREAM, named_vector

PREDICTED = ('prediction', 'prediction_stddev')


class EstimatePublisher:
    """Publishes estimates: ~/state, ~/parameters, their standard deviations, and so on.

    With `predicting` ~/prediction too, and its deviations. ~/residual goes with the predictions, or
    else with the estimates of observers that tell innovations.
    """

    def __init__(self, node: Node, model: Model, *, predicting: bool) -> None:
        self._node, self._model = node, model
        rare = {*TOPICS} - {'residual'} if predicting else {*()}  # one for a window, not a sample
        self._publishers = {
            topic: node.create_publisher(
                JointState, f'~/{topic}', copy(ESTIMATES if topic in rare else STREAM),
                qos_overriding_options=OVERRIDABLE,
            )
            for topic in (*TOPICS, *(PREDICTED if predicting else ()))
        }  # fmt: skip
        self._outcome = node.create_publisher(String, '~/outcome', LATCHED)

    def destroy(self) -> None:
        """Publish nothing any more."""
        for publisher in (*self._publishers.values(), self._outcome):
            self._node.destroy_publisher(publisher)

    def publish_prediction(self, predicted: Predicted) -> None:
        """Publish the states at the newest output, and the residual of that."""
        for topic, values, effort in (
            ('prediction', predicted.state, ()),
            ('prediction_stddev', predicted.stddev, ()),
            ('residual', predicted.residual, predicted.residual_stddev.values()),
        ):
            message = named_vector(predicted.stamp, values, values.values(), effort=effort)
            self._publishers[topic].publish(message)

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
        for topic, stamp, values, velocity, effort in vectors(estimate, self._model, timing):
            position = map(float, values.values())
            message = named_vector(stamp, values, position, velocity, effort)
            self._publishers[topic].publish(message)
        return publishable(estimate)
