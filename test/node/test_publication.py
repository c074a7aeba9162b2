"""An estimate goes out as messages, or is withheld."""

import dataclasses
import json
import math

import pytest
from interface.test_vectors import ESTIMATE, LEVELS, TANKS, VALVES
from ros import vector
from std_msgs.msg import String

from obs_ros.ros.messages import LATCHED
from obs_ros.ros.publication import EstimatePublisher


@pytest.fixture
def publisher(ros):
    return EstimatePublisher(ros.node, TANKS, predicting=True)


def test_values_go_out_with_their_outcome_and_timing(ros, publisher):
    topics = ('state', 'parameters', 'state_stddev', 'jump', 'solver')
    heard = {topic: ros.listen(f'/test/{topic}') for topic in topics}
    outcomes = ros.listen('/test/outcome', String, LATCHED)
    assert publisher.publish(ESTIMATE, latency=0.25, skipped=3)
    ros.spin_until(lambda: outcomes and all(heard.values()))
    assert json.loads(outcomes[0].data) == {
        'stamp_ns': 9 * 10**9, 'outcome': 'converged', 'message': '',
    }  # fmt: skip
    assert vector(heard['state'][0]) == LEVELS and vector(heard['parameters'][0]) == VALVES
    assert vector(heard['jump'][0]) == {'p3': -0.3} and heard['jump'][0].header.stamp.sec == 5
    solver = vector(heard['solver'][0])
    assert (solver['latency_s'], solver['skipped'], solver['gain']) == (0.25, 3.0, 4.0)


def test_only_figures_and_outcome_go_out_of_what_is_not_finite(ros, publisher):
    states, solver = ros.listen('/test/state'), ros.listen('/test/solver')
    lost = dataclasses.replace(ESTIMATE, state={**LEVELS, 'h1': math.nan})
    assert not publisher.publish(lost, latency=0.1, skipped=0)
    ros.spin_until(lambda: solver)
    assert not states


def test_predictions_are_named_and_stamped(ros, publisher):
    heard = ros.listen('/test/prediction')
    publisher.publish_prediction(2_500_000_000, LEVELS)
    ros.spin_until(lambda: heard)
    assert vector(heard[0]) == LEVELS and heard[0].header.stamp.nanosec == 500_000_000
