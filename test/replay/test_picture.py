"""What the pictures of a replay show, read from their axes."""

import numpy as np
import pytest
from ball_and_beam import BALL, motion

from obs_ros.core.record import Sample
from obs_ros.models import load_model
from obs_ros.replay import picture, trace
from obs_ros.replay.engine import replay
from obs_ros.replay.fitted import fitted_outputs, outputs_of_states
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
def axes(tmp_path, monkeypatch):
    """A function that draws, and returns the axes of each picture by its name."""
    pytest.importorskip('matplotlib')
    drawn = {}
    finish = picture._finish

    def keep(plt, figure, axes, account, path):
        drawn[path.name] = list(axes), figure
        finish(plt, figure, axes, account, path)

    monkeypatch.setattr(picture, '_finish', keep)

    def draw(account):
        picture.draw(account, tmp_path)
        return drawn

    return draw


def line(ax, *, points):
    """Return x and y of the one curve of that many points."""
    (found,) = [curve for curve in ax.lines if len(curve.get_xdata()) == points]
    return np.asarray(found.get_xdata()), np.asarray(found.get_ydata())


def test_states_are_drawn_as_the_path_that_windows_found_beside_what_was_measured(axes):
    pages = axes(account())
    (place, speed), figure = pages['states.png']
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


def test_a_spike_does_not_flatten_the_rest(axes):
    y = Y.copy()
    y[SPIKE] = 5.0
    (place, _), _ = axes(account(y))['states.png']
    low, high = place.get_ylim()
    assert R.min() > low and R.max() < high and high - low < 2.0 * np.ptp(R)


def test_the_longest_title_and_the_longest_legend_do_not_meet():
    plt = pytest.importorskip('matplotlib.pyplot')
    figure, _ = picture._panels(plt, 2, 'States and outputs, ± 2 sd')
    with plt.rc_context(picture.STYLE):
        picture._legend(figure, dots=True, jumps=True, path=True)
        figure.canvas.draw()
    assert len(figure.legends[0].get_texts()) == 6
    assert not figure.legends[0].get_window_extent().overlaps(figure._suptitle.get_window_extent())
    plt.close(figure)


def test_an_observer_that_goes_sample_by_sample_is_drawn_as_one_line(axes):
    given = {'noise.y': NOISE, 'initial.r': 0.1, 'initial.a': 5.0}
    (place, _), figure = axes(account(observer='ekf', **given))['states.png']
    assert 'estimate' in [text.get_text() for text in figure.legends[0].get_texts()]
    curves = [np.asarray(curve.get_ydata()) for curve in place.lines]
    assert any(curve.size == T.size and abs(curve - R)[-1] < 5.0 * NOISE for curve in curves)


def test_the_path_between_windows_that_do_not_meet_is_interrupted():
    t, x = picture._broken(np.array([0.0, 0.1, 0.2, 5.0, 5.1]), np.arange(5.0))
    np.testing.assert_array_equal(np.isnan(x), [False, False, False, True, False, False])
    assert t.size == x.size


def test_outputs_that_are_states_are_known_by_what_they_do():
    assert outputs_of_states(BALL) == {0: 0}
    suspension = load_model('suspension')
    # zd is the difference of two states.
    assert outputs_of_states(suspension) == {0: 0, 2: 1}


def test_outputs_that_are_no_state_follow_the_path_and_the_parameters_before_a_jump():
    from obs_ros import Model, Variable

    def output(t, x, u, p):
        return (p[0] * x[0] + u[0],)

    model = Model(
        name='gain', states=(Variable('x', lower=-9, upper=9),), inputs=(Variable('u'),),
        outputs=(Variable('y'),), parameters=(Variable('k', lower=0, upper=9),),
        dynamics=lambda t, x, u, p: (-p[0] * x[0] + u[0],), output=output,
    )  # fmt: skip
    from obs_ros.core.estimate import Estimate, Jump, Outcome
    from obs_ros.replay.history import History

    history = History(model)
    for second, u in enumerate((1.0, 2.0, 4.0)):
        history.record(Sample(second * 10**9, u=np.array([u])))
    jump = Jump(1.5, 0.1, {'k': 3.0}, {'k': 0.1}, new=True, stamp=1_500_000_000)
    history.add(
        Estimate(
            {'k': 5.0}, {'x': 1.0}, {'x': 3.0}, {}, Outcome.CONVERGED, '', 0.0, 2.0, jumps=(jump,),
            times=np.arange(3.0), states=np.array([[1.0], [2.0], [3.0]]), stamp=2_000_000_000,
        )
    )  # fmt: skip
    np.testing.assert_allclose(history.path.rows, [[1.0, 2.0], [2.0, 2.0], [3.0, 5.0]])
    np.testing.assert_allclose(fitted_outputs(history)[:, 0], [2.0 + 1.0, 4.0 + 2.0, 15.0 + 4.0])


@pytest.mark.parametrize('count', [5, 2 * trace.MOST - 1, 2 * trace.MOST, 50_000])
def test_a_trace_keeps_evenly_spaced_rows_and_never_many(count):
    kept = trace.Trace(2)
    for k in range(count):
        kept.add(k, (k, -k))
    assert min(count, trace.MOST) <= len(kept) < 2 * trace.MOST
    np.testing.assert_array_equal(kept.rows, np.column_stack([kept.stamps, -kept.stamps]))
    steps = np.diff(kept.stamps)
    assert kept.stamps[0] == 0 and (steps == steps[0]).all()
    assert count - 1 - kept.stamps[-1] < steps[0]
