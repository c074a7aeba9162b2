"""The way from topics to the observer: in order of stamp, whatever the backlog, with arrivals."""

import time
from functools import partial

import numpy as np
import pytest
from node.fakes import FakeObserver
from plants import tank_outputs
from ros import figures, vector
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64

from obs_ros.core.record import Sample
from obs_ros.observers.base import load_observer
from obs_ros.ros.estimator import Estimator
from obs_ros.ros.messages import STREAM
from obs_ros.samples.merge import Merge, MergeSettings

S = 10**9
LEVELS, FLOWS = ('h1', 'h2'), ('Q1', 'Q2')


class Stall:
    """While it lasts the estimator stands still, as a stopped process does, and messages wait."""

    def __init__(self, ros, estimator, **kinds):
        self._ros, self._estimator, self._kinds = ros, estimator, kinds

    def __enter__(self):
        self._ros.executor.remove_node(self._estimator)
        self._echoes = {topic: [] for topic in self._kinds}
        self._subscriptions = [
            self._ros.node.create_subscription(kind, topic, self._echoes[topic].append, STREAM)
            for topic, kind in self._kinds.items()
        ]
        for subscription in self._subscriptions:
            self._ros.spin_until(lambda each=subscription: each.get_publisher_count())
        return self

    def until(self, **counts):
        """Wait until so many messages have come over each topic."""
        self._ros.spin_until(lambda: all(len(self._echoes[t]) >= n for t, n in counts.items()))

    def __exit__(self, *_):
        for subscription in self._subscriptions:
            self._ros.node.destroy_subscription(subscription)
        self._ros.executor.add_node(self._estimator)


def flows(k):
    return 30.0 + 20.0 * np.sin(0.7 * k), 30.0 - 10.0 * np.sin(0.3 * k)


@pytest.mark.parametrize('first', ['outputs', 'inputs'])
@pytest.mark.parametrize('observer', ['ekf', 'ukf'])
def test_a_stall_costs_a_filter_nothing(ros, monkeypatch, observer, first):
    """One topic delivers its whole backlog before the other: no output meets an old input."""
    patience = MergeSettings(longest_due=60.0)  # however slow this machine is
    monkeypatch.setattr('obs_ros.ros.streams.Merge', partial(Merge, settings=patience))
    levels = tank_outputs(np.arange(200.0), (50.0, 40.0, 45.0), (0.6, 0.5, 0.7))
    noise = {'h1': 0.01, 'h2': 0.01}
    alone = load_observer(observer)('three_tank', noise=noise)
    expected = []
    for k, y in enumerate(levels):
        alone.absorb(Sample(k * S, u=np.array(flows(k))))
        assert alone.absorb(Sample(k * S, y=y))
        expected.append(list(alone.estimate().state.values()))
    estimator = ros.start(
        Estimator, observer=observer, merge_wait=60.0, noise__h1=0.01, noise__h2=0.01
    )
    ros.spin_until(lambda: estimator.estimation.progress.ready, timeout=60.0)
    states = ros.listen('/estimator/state')
    output, given = ros.speak('/plant/output'), ros.speak('/plant/input')
    for k in range(20):
        given(k, FLOWS, flows(k))
        output(k, LEVELS, levels[k])
    ros.spin_until(lambda: len(states) == 20)
    with Stall(
        ros, estimator, **{'/plant/output': JointState, '/plant/input': JointState}
    ) as stall:
        for role in ('outputs', 'inputs') if first == 'outputs' else ('inputs', 'outputs'):
            for k in range(20, 200):
                if role == 'outputs':
                    output(k, LEVELS, levels[k])
                else:
                    given(k, FLOWS, flows(k))
        stall.until(**{'/plant/output': 180, '/plant/input': 180})
    ros.spin_until(lambda: len(states) == 200)
    assert [m.header.stamp.sec for m in states] == list(range(200))
    assert [list(vector(m).values()) for m in states] == expected
    assert figures(ros.health(outcome='converged'))['samples.late'] == '0'


def test_the_stamp_of_an_arrival_is_when_it_came_and_not_when_it_was_read(ros):
    FakeObserver.made.clear()
    estimator = ros.start(
        Estimator,
        observer='node.fakes:FakeObserver',
        window__duration=1.0,
        signals__h1__topic='/level',
        signals__h1__type='std_msgs/msg/Float64',
        signals__h1__field='data',
        signals__h1__stamp='arrival',
        merge_wait=0.0,
    )
    publisher = ros.node.create_publisher(Float64, '/level', STREAM)
    ros.spin_until(publisher.get_subscription_count)
    begin = time.time_ns()
    with Stall(ros, estimator, **{'/level': Float64}) as stall:
        for k in range(20):
            publisher.publish(Float64(data=float(k)))
        stall.until(**{'/level': 20})
        end = time.time_ns()
    outputs = FakeObserver.made[-1].outputs
    ros.spin_until(lambda: outputs)
    assert begin <= outputs[0].stamp <= end
    ros.spin_until(lambda: outputs[-1].y[0] == 19.0)
