"""What the pictures of a replay show, read from their axes."""

from dataclasses import replace

import numpy as np
import pytest
from ball_and_beam import motion

from obs_ros.core.estimate import Estimate, Jump, Outcome
from obs_ros.core.record import Sample
from obs_ros.replay import picture
from obs_ros.replay.engine import Account, replay
from obs_ros.replay.history import History
from obs_ros.replay.settings import setup

NOISE = 0.001  # m
T, U, R, V = motion(160)
Y = R + NOISE * np.random.default_rng(1).standard_normal(T.size)
SPIKE = 70  # the sample at which the sensor says 5 m


def samples(y=Y):
    for t, u, value in zip(T, U, y):
        stamp = round(t * 1e9)
        yield Sample(stamp, u=np.array([u]))
        yield Sample(stamp, y=np.array([value]))


def account(y=Y, **values):
    given = {'model': 'ball_and_beam:BALL', 'window.duration': 5.0, 'window.period': 2.5, **values}
    return replay(setup(given), samples(y))


@pytest.fixture
def drawn():
    """A function that returns the figures of an account by the names of their files."""
    plt = pytest.importorskip('matplotlib.pyplot')
    yield lambda account: dict(picture.figures(plt, account))
    plt.close('all')


def line(ax, *, points):
    """Return x and y of the one curve of that many points."""
    (found,) = [curve for curve in ax.lines if len(curve.get_xdata()) == points]
    return np.asarray(found.get_xdata()), np.asarray(found.get_ydata())


def test_states_are_drawn_as_the_path_that_windows_found_beside_what_was_measured(drawn):
    figure = drawn(account())['states.png']
    place, speed = figure.axes
    last = 151  # samples up to the end of the fifth window, which is at 15 s
    for ax, truth, tolerance in ((place, R, 3.0 * NOISE), (speed, V, 0.02)):
        t, values = line(ax, points=last)
        np.testing.assert_allclose(t, T[:last], atol=1e-9)
        np.testing.assert_allclose(values, truth[:last], atol=tolerance)
    t, values = line(place, points=T.size)
    np.testing.assert_allclose((t, values), (T, Y), atol=1e-9)
    assert [ax.get_ylabel() for ax in (place, speed)] == ['r (m)', 'v (m/s)']
    assert speed.get_xlabel() == 'time (s)'
    words = [text.get_text() for text in figure.legends[0].get_texts()]
    assert words[:2] == ['fitted path', 'measured']
    # Estimates, with their deviations, at the ends of the windows.
    t, values = line(place, points=5)
    np.testing.assert_allclose(t, [5.0, 7.5, 10.0, 12.5, 15.0])


def test_intervals_are_drawn_as_far_as_they_reach_to_either_side(drawn):
    chosen = setup({'model': 'plants:VESSEL'})
    told = Account(History(chosen.model), first=0, horizon=1.0)
    for k, jump in enumerate((True, False, True)):
        shown = Jump(0.5 + k, 0.1, {'d': 1.0}, {'d': 0.1}, jump, stamp=round((0.5 + k) * 1e9))
        nan = float('nan')
        told.history.add(
            Estimate(
                parameters={'d': 2.0 + k, 'g': 0.5}, initial_state={'x': 1.0}, state={'x': 1.0},
                stddev={'d': 0.5}, outcome=Outcome.CONVERGED, message='', t0=0.0, t1=1.0 + k,
                interval={'d': (1.9 + k, 2.5 + k), 'g': (nan, nan)}, stamp=(1 + k) * 10**9,
                jumps=(shown,),
            )
        )  # fmt: skip
    back = replace(told.history.jumps[0], sizes={'d': 0.0}, retracted=True)
    told.history.jumps.append(back)
    d, g = drawn(told)['parameters.png'].axes
    (bars,) = d.collections[-1:]
    ends = np.array([segment[:, 1] for segment in bars.get_segments()])
    np.testing.assert_allclose(ends, [[1.9, 2.5], [2.9, 3.5], [3.9, 4.5]])
    crosses = [curve for curve in g.lines if curve.get_marker() == 'x']
    assert sum(len(curve.get_xdata()) for curve in crosses) == 3
    dashed = [curve.get_xdata()[0] for curve in d.lines if curve.get_linestyle() == '--']
    assert dashed == [2.5], 'one is no news, and one was taken back'


def test_a_spike_does_not_flatten_the_rest(drawn):
    y = Y.copy()
    y[SPIKE] = 5.0
    place, _ = drawn(account(y))['states.png'].axes
    low, high = place.get_ylim()
    assert R.min() > low and R.max() < high and high - low < 2.0 * np.ptp(R)


def test_an_observer_that_goes_sample_by_sample_is_drawn_as_one_line(drawn):
    given = {'noise.y': NOISE, 'initial.r': 0.1, 'initial.a': 5.0}
    figure = drawn(account(observer='ekf', **given))['states.png']
    place, _ = figure.axes
    assert 'estimate' in [text.get_text() for text in figure.legends[0].get_texts()]
    curves = [np.asarray(curve.get_ydata()) for curve in place.lines]
    assert any(curve.size == T.size and abs(curve - R)[-1] < 5.0 * NOISE for curve in curves)
