"""The real rig: a ball on a beam, recorded with nobody's simulator (skipped where it is absent)."""

import numpy as np
import pytest
from ball_and_beam import BALL, real_recording

from obs_ros.replay.engine import replay
from obs_ros.replay.settings import setup
from obs_ros.replay.table import Table

PERIOD = 0.1  # s, of the recording
GIVEN = {'model': 'ball_and_beam:BALL', 'window.duration': 5.0}
SPEED = 100.0  # times real time


def samples():
    return Table(real_recording(), {}, PERIOD, BALL)


def replayed():
    taken = []
    account = replay(setup(GIVEN), samples(), take=lambda estimate, _: taken.append(estimate))
    return account, taken


def test_windows_of_five_seconds_fit_within_millimetres():
    account, taken = replayed()
    assert len(taken) == 19
    residuals = account.history.rows('residuals')[:, 0]
    assert np.median(residuals) < 2e-3  # m
    assert residuals.max() < 5e-3
    values = account.history.rows('values')
    assert 4.0 < np.median(values[:, 2]) < 5.5  # a in m/s2
    assert np.median(values[:, 3]) < 0.1  # b in 1/s
    assert abs(np.median(values[:, 4])) < 0.02  # c in m/s2
    assert account.counts['skipped'] == 0
    assert account.failed == 0


def test_the_live_node_estimates_what_the_replay_does(ros):
    """At 100 times real time; it stands still at the end of a window until that is solved."""
    from live_feed import LiveFeed
    from ros import vector

    from obs_ros.node.estimator import Estimator

    recording = samples()
    _, taken = replayed()
    estimator = ros.start(
        Estimator, model=GIVEN['model'], window__duration=GIVEN['window.duration'], deadline=60.0
    )
    topics = ('parameters', 'state', 'parameters_stddev', 'state_stddev')
    heard = {topic: ros.listen(f'/estimator/{topic}') for topic in topics}
    jumps = ros.listen('/estimator/jump')
    ros.spin_until(lambda: estimator.progress.ready, timeout=90.0)
    ends = [estimate.stamp for estimate in taken]

    def behind(stamp):
        closed = sum(end < stamp - 1e9 * PERIOD for end in ends)
        return len(heard['state_stddev']) < closed

    speed = LiveFeed(ros, BALL, SPEED).play(recording, wait=behind)
    ros.spin_until(lambda: all(len(messages) >= len(taken) for messages in heard.values()))
    assert speed <= SPEED * 1.01
    for k, estimate in enumerate(taken):
        for topic, messages in heard.items():
            stamp = messages[k].header.stamp
            assert stamp.sec * 10**9 + stamp.nanosec == estimate.stamp
            values = vector(messages[k])
            source = estimate.stddev if 'stddev' in topic else getattr(estimate, topic)
            expected = {name: source[name] for name in values}
            assert values == pytest.approx(expected, rel=0, abs=0, nan_ok=True), (k, topic)
    announced = [dict(jump.sizes) for e in taken for jump in e.jumps if jump.new]
    assert [vector(message) for message in jumps] == announced
    assert estimator.progress.failed == 0
