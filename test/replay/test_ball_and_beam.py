"""A ball on a beam, recorded: the live node says what the replay does, of the real rig as well.

The recording of the real rig, made with nobody's simulator, is not in the repository: what needs it
is skipped where it is absent.
"""

import numpy as np
import pytest
from ball_and_beam import BALL, made_up, real_recording

from obs_ros.core.model import names
from obs_ros.replay.engine import replay
from obs_ros.replay.settings import setup
from obs_ros.replay.table import Table

PERIOD = 0.1  # s, of the recordings
GIVEN = {'model': 'ball_and_beam:BALL', 'window.duration': 5.0}


def samples(path):
    return Table(path, {}, PERIOD, BALL)


def replayed(path):
    taken = []
    account = replay(setup(GIVEN), samples(path), take=lambda estimate, _: taken.append(estimate))
    return account, taken


def tilted(path):
    """Write 30 s of a made-up rig that is tilted after 13 s."""
    _, u, y = made_up(rows=301, seed=3, noise=5e-4, tilted=13.0)
    rows = [f'{a!r},{b!r}' for a, b in zip(u.tolist(), y.tolist())]
    path.write_text('\n'.join(['u,y', *rows]) + '\n')
    return path


def test_windows_of_five_seconds_fit_within_millimetres():
    account, taken = replayed(real_recording())
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


@pytest.mark.parametrize('recorded', ['made up', 'real'])
def test_the_live_node_estimates_what_the_replay_does(ros, tmp_path, recorded):
    """Bit for bit; the recording stands still at the end of a window until that is solved."""
    from ros import vector

    from obs_ros.ros.estimator import Estimator

    path = tilted(tmp_path / 'rig.csv') if recorded == 'made up' else real_recording()
    _, taken = replayed(path)
    estimator = ros.start(
        Estimator, model=GIVEN['model'], window__duration=GIVEN['window.duration'], deadline=60.0
    )
    topics = ('parameters', 'state', 'parameters_stddev', 'state_stddev')
    heard = {topic: ros.listen(f'/estimator/{topic}') for topic in topics}
    jumps = ros.listen('/estimator/jump')
    intervals = ros.listen('/estimator/parameters_interval')
    ros.spin_until(lambda: estimator.estimation.progress.ready, timeout=90.0)
    play(ros, samples(path), [estimate.stamp for estimate in taken], heard['state_stddev'])
    ros.spin_until(lambda: all(len(messages) >= len(taken) for messages in heard.values()))
    for k, estimate in enumerate(taken):
        for topic, messages in heard.items():
            stamp = messages[k].header.stamp
            assert stamp.sec * 10**9 + stamp.nanosec == estimate.stamp
            values = vector(messages[k])
            source = estimate.stddev if 'stddev' in topic else getattr(estimate, topic)
            expected = {name: source[name] for name in values}
            assert values == pytest.approx(expected, rel=0, abs=0, nan_ok=True), (k, topic)
    ros.spin_until(lambda: len(intervals) >= len(taken))
    for message, estimate in zip(intervals, taken, strict=True):
        expected = [estimate.interval[name] for name in message.name]
        found = list(zip(message.position, message.velocity, strict=True))
        np.testing.assert_array_equal(found, expected)
    announced = [jump for e in taken for jump in e.jumps if jump.new]
    assert [vector(message) for message in jumps] == [dict(jump.sizes) for jump in announced]
    for message, jump in zip(jumps, announced, strict=True):
        assert list(message.effort) == list(jump.stddev.values())
        assert list(message.velocity) == pytest.approx(
            [jump.probability] * len(jump.sizes), rel=0, abs=0, nan_ok=True
        )
    assert estimator.estimation.progress.failed == 0
    if recorded == 'made up':
        assert len(taken) == 6 and announced


def play(ros, recording, ends, heard):
    """Publish a recording; after each of the `ends` (ns) wait until its estimate is heard."""
    order = {'output': names(BALL.outputs), 'input': names(BALL.inputs)}
    speak = {stream: ros.speak(f'/plant/{stream}') for stream in order}
    for sample in recording:
        closed = sum(end < sample.stamp - 1e9 * PERIOD for end in ends)
        ros.spin_until(lambda n=closed: len(heard) >= n, timeout=60.0)
        for stream, values in (('input', sample.u), ('output', sample.y)):
            if values is not None:
                speak[stream](sample.stamp / 1e9, order[stream], values)
