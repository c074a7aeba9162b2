"""An estimate goes out as messages, or is withheld."""

import dataclasses
import json
import math

import pytest
import yaml
from interface.test_vectors import ESTIMATE, LEVELS, TANKS, VALVES
from ros import vector
from std_msgs.msg import String

from obs_ros import Outcome
from obs_ros.horizon.prediction import Predicted
from obs_ros.ros.messages import LATCHED
from obs_ros.ros.publication import EstimatePublisher


@pytest.fixture
def publisher(ros):
    return EstimatePublisher(ros.node, TANKS, predicting=True)


def test_values_go_out_with_their_outcome_and_timing(ros, publisher):
    topics = ('state', 'parameters', 'state_stddev', 'parameters_interval', 'jump', 'solver')
    heard = {topic: ros.listen(f'/test/{topic}') for topic in topics}
    outcomes = ros.listen('/test/outcome', String, LATCHED)
    assert publisher.publish(ESTIMATE, latency=0.25, skipped=3)
    ros.spin_until(lambda: outcomes and all(heard.values()))
    assert json.loads(outcomes[0].data) == {
        'stamp_ns': 9 * 10**9, 'outcome': 'converged', 'message': '',
    }  # fmt: skip
    assert vector(heard['state'][0]) == LEVELS and vector(heard['parameters'][0]) == VALVES
    jump, interval = heard['jump'][0], heard['parameters_interval'][0]
    assert vector(jump) == {'p3': -0.3, 'p2': 0.1} and jump.header.stamp.sec == 5
    assert list(jump.velocity) == [0.96, 0.96] and list(jump.effort) == [0.01, 0.02]
    assert interval.name == ['p1', 'p2', 'p3'] and interval.header == heard['state'][0].header
    assert math.isnan(interval.position[0]) and math.isnan(interval.velocity[0])
    assert (interval.position[2], interval.velocity[2]) == (0.28, 0.34)
    solver = vector(heard['solver'][0])
    assert (solver['latency_s'], solver['skipped'], solver['gain']) == (0.25, 3.0, 4.0)


def test_the_newest_outcome_is_there_for_a_subscriber_that_comes_late(ros, publisher):
    said = 'look at the sensor: "h1" repeats 3.1 \u00b0C'
    for stamp, outcome in ((1, Outcome.CONVERGED), (2, Outcome.STALE_OUTPUT)):
        told = dataclasses.replace(ESTIMATE, outcome=outcome, message=said, stamp=stamp)
        publisher.publish(told, latency=0.25, skipped=0)
    outcomes = ros.listen('/test/outcome', String, LATCHED)
    ros.spin_until(lambda: outcomes)
    expected = {'stamp_ns': 2, 'outcome': 'stale_output', 'message': said}
    assert [yaml.safe_load(one.data) for one in outcomes] == [expected]


def test_only_figures_and_outcome_go_out_of_what_is_not_finite(ros, publisher):
    states, solver = ros.listen('/test/state'), ros.listen('/test/solver')
    lost = dataclasses.replace(ESTIMATE, state={**LEVELS, 'h1': math.nan})
    assert not publisher.publish(lost, latency=0.1, skipped=0)
    ros.spin_until(lambda: solver)
    assert not states


def test_the_innovation_of_an_estimate_goes_out_with_its_deviation(ros, publisher):
    heard = ros.listen('/test/residual')
    assert publisher.publish(ESTIMATE, latency=0.25, skipped=3)
    ros.spin_until(lambda: heard)
    assert heard[0].name == ['h1', 'h2'] and heard[0].header.stamp.sec == 9
    assert heard[0].position[0] == 0.2 and heard[0].effort[0] == 0.1
    assert math.isnan(heard[0].position[1]) and math.isnan(heard[0].effort[1])


def test_predictions_are_named_and_stamped(ros, publisher):
    heard = {t: ros.listen(f'/test/{t}') for t in ('prediction', 'prediction_stddev', 'residual')}
    predicted = Predicted(2_500_000_000, LEVELS, {'h1': 0.5}, {'h2': 0.25}, {'h2': 0.125})
    publisher.publish_prediction(predicted)
    ros.spin_until(lambda: all(heard.values()))
    state, stddev, residual = (messages[0] for messages in heard.values())
    assert vector(state) == LEVELS and state.header.stamp.nanosec == 500_000_000
    assert vector(stddev) == {'h1': 0.5} and stddev.header == state.header
    assert vector(residual) == {'h2': 0.25} and residual.header == state.header
    assert list(residual.effort) == [0.125] and not state.effort and not stddev.effort
