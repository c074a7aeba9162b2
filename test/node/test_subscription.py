"""A subscribed topic: arrivals, silence, refusals and lost messages."""

import time

from node.fakes import FakeImmediate
from ros import vector

from obs_ros.interface.readers import VectorReader
from obs_ros.ros import subscription
from obs_ros.ros.estimator import Estimator
from obs_ros.ros.guarded import GuardedNode
from obs_ros.ros.subscription import Subscription
from obs_ros.samples.merge import Merge

LEVELS, FLOWS = ('h1', 'h2'), ('Q1', 'Q2')


class Wall:
    """The clocks that arrivals are told by, the wall's ahead: as if messages had waited unread."""

    monotonic = staticmethod(time.monotonic)

    def __init__(self, ahead: float) -> None:
        self._ahead = round(ahead * 1e9)

    def time_ns(self) -> int:
        return time.time_ns() + self._ahead


def test_latency_and_lag_count_from_when_the_middleware_had_the_message(ros, monkeypatch):
    FakeImmediate.go.set()
    estimator = ros.start(Estimator, observer='node.fakes:FakeImmediate')
    ros.spin_until(lambda: estimator.estimation.progress.ready)
    solver = ros.listen('/estimator/solver')
    output, given = ros.speak('/plant/output'), ros.speak('/plant/input')
    given(1, FLOWS, (30, 30))
    ros.spin_until(lambda: estimator.estimation.streams.subscriptions['input'].received)
    monkeypatch.setattr(subscription, 'time', Wall(ahead=1000.0))
    began = time.time()
    output(1, LEVELS, (1, 1))
    ros.spin_until(lambda: solver)
    passed = time.time() - began
    assert 1000.0 <= vector(solver[0])['latency_s'] <= 1000.0 + passed
    assert 1000.0 <= estimator.estimation.progress.behind <= 1000.0 + passed


def test_a_pause_is_no_silence(ros):
    """After ~/enable, a stream is stale when it has been silent for that long since."""
    estimator = ros.start(Estimator, observer='node.fakes:FakeObserver', window__duration=1.0)
    output = ros.speak('/plant/output')
    output(1, LEVELS, (1, 1))
    heard, never = (
        estimator.estimation.streams.subscriptions[role] for role in ('output', 'input')
    )
    ros.spin_until(lambda: heard.received)
    before = time.monotonic()
    ros.spin_until(lambda: heard.silence > time.monotonic() - before)
    heard.rest()
    assert heard.silence <= time.monotonic() - before
    assert never.silence is None
    never.rest()
    assert never.silence is None, 'what never came is waited for, not stale'


def test_its_status_tells_what_came_what_was_refused_and_how_often(ros):
    taken = []
    merge = Merge(0.0, lambda sample, arrival: taken.append(sample))
    node = ros.start(lambda **options: GuardedNode('listener', **options))
    heard = Subscription(node, 'plant/output', 'output', VectorReader(LEVELS), merge, lambda: None)
    first = heard.status()
    assert (first.silence, first.stamp, first.received, first.publishers) == (None, None, 0, 0)
    speak = ros.speak('/plant/output')
    speak(1.0, LEVELS, (1.0, 2.0))
    speak(2.0, ('h1', 'h9'), (1.0, 2.0))
    ros.spin_until(lambda: heard.received == 2)
    status = heard.status()
    assert status.refuses and dict(status.refused) == {'missing_name': 1}
    assert status.last_refusal.startswith("plant/output: 'h2' is missing: did you mean 'h9'?")
    assert (status.stamp, status.publishers, status.lost) == (10**9, 1, 0)
    assert status.reliable and not status.alternating and status.rate > 0.0
    assert heard.status().rate == 0.0, 'nothing came since'
