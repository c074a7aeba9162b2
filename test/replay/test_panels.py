"""Panels keep to what can be read: titles, legends, limits, gaps."""

import numpy as np
import pytest

from obs_ros.core.model import Variable
from obs_ros.replay.panels import (
    STYLE,
    Band,
    broken,
    finish,
    label,
    legend,
    limit,
    panels,
    usual,
    wraps,
)  # fmt: skip


@pytest.fixture
def plt():
    pyplot = pytest.importorskip('matplotlib.pyplot')
    yield pyplot
    pyplot.close('all')


def test_the_longest_title_and_the_longest_legend_do_not_meet(plt):
    figure, _ = panels(plt, 2, 'States and outputs, 95 % intervals')
    with plt.rc_context(STYLE):
        legend(figure, dots=True, jumps=True, path=True)
        figure.canvas.draw()
    (title,) = [text for text in figure.texts if text.get_text().startswith('States')]
    assert len(figure.legends[0].get_texts()) == 6
    assert not figure.legends[0].get_window_extent().overlaps(title.get_window_extent())


def test_the_path_between_windows_that_do_not_meet_is_interrupted():
    t, x = broken(np.array([0.0, 0.1, 0.2, 5.0, 5.1]), np.arange(5.0))
    np.testing.assert_array_equal(np.isnan(x), [False, False, False, True, False, False])
    assert t.size == x.size


def test_a_line_without_gaps_stays_as_it_is():
    t = np.array([0.0, 0.1, 0.2, 0.3])
    np.testing.assert_array_equal(broken(t, 2.0 * t), (t, 2.0 * t))


def test_odd_values_are_drawn_in_and_the_rest_kept():
    values = np.arange(1001.0)
    values[500] = 1e6
    found = usual(values)
    # As far beyond 99 % of the values as these are from the middle.
    np.testing.assert_allclose(found.max(), 990.0 + 490.0, atol=2.0)
    assert (found[20:480] == values[20:480]).all() and usual(np.empty(0)).size == 0


def test_limits_hold_values_and_usual_bands_and_stay_within_the_bounds(plt):
    _, (ax,) = panels(plt, 1, 'x')
    limit(ax, np.array([1.0, 2.0, np.nan]), (0.9, 9.0), (0.2, 0.1))
    np.testing.assert_allclose(ax.get_ylim(), (0.9 - 0.08 * 1.4, 2.3 + 0.08 * 1.4))
    before = ax.get_ylim()
    limit(ax, np.array([np.nan]), (0.0, 1.0), (0.1, 0.1))
    assert ax.get_ylim() == before


def test_a_band_reaches_as_far_as_its_intervals_on_either_side():
    nan = np.nan
    band = Band(*np.array([[1.0, 2.0, 3.0, nan], [0.9, 1.5, nan, nan], [1.4, 2.2, nan, nan]]))
    assert band.known.tolist() == [True, True, False, False]
    np.testing.assert_allclose(band.reach, [[0.1, 0.5, 0.0, 0.0], [0.4, 0.2, 0.0, 0.0]])
    assert band.usual_reach == pytest.approx((0.3, 0.3))
    assert Band(*np.full((3, 2), nan)).usual_reach == (0.0, 0.0)


def test_axes_are_named_with_their_units_and_the_begin(plt):
    figure, (above, below) = panels(plt, 2, 'x')
    label(above, Variable('v', 'm/s'))
    label(below, Variable('share'), 'rms of ')
    finish(figure, (above, below), 1_500_000_000)
    assert (above.get_ylabel(), below.get_ylabel()) == ('v (m/s)', 'rms of share')
    assert below.get_xlabel() == 'time (s since 1.500)' and not above.get_xlabel()


def test_a_line_that_wraps_is_interrupted_there():
    values = np.array([3.0, -3.0, -2.9, np.nan, 2.0])
    assert wraps(values, 2.0 * np.pi).tolist() == [1] and not wraps(values, None).size
    t, x = broken(np.arange(5.0), values, 2.0 * np.pi)
    assert t.size == x.size == 6 and np.isnan(x[1]) and x[2] == -3.0
