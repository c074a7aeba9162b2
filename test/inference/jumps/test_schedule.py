"""Tests of obs_ros.inference.jumps.schedule: parameters along a window, and their prior."""

import numpy as np
import pytest

from obs_ros.inference.jumps.layout import Layout
from obs_ros.inference.jumps.schedule import moments, normal, scheduled

T = np.arange(6.0)


def test_times_have_intervals_of_their_own_and_those_near_a_node_are_at_it() -> None:
    shares = np.array([[0.5, 0.4], [0.4 + 1e-9, 1.0], [0.0, 1.5]])
    times, intervals = moments(shares, T, 1e-6)
    assert times.tolist() == [[2.5, 2.0, 0.0], [2.0, 5.0, 7.5]]
    assert intervals.tolist() == [[2, 1, 0], [1, 4, 4]]


def test_a_parameter_has_its_mean_over_the_interval_of_its_jump() -> None:
    """The first of two jumps at 2.25 s, and of another candidate at 3.5 s; then both at 4 s."""
    times, p = np.array([[2.25, 3.5], [4.0, 4.0]]), np.array([[1.0, 2.0], [5.0, 6.0]])
    event, row = np.array([0, 1, 1]), np.array([0, 0, 1])
    values = np.array([[3.0, 4.0], [7.0, 8.0], [9.0, 9.0]])
    _, intervals = moments(times.T / T[-1], T, 0.0)
    sets, along, there = scheduled(times, intervals, T, event, row, values, p)
    assert along.tolist() == [0, 0, 1, 3, 4, 4] and there.tolist() == [0, 0, 0, 2, 4, 4]
    np.testing.assert_allclose(sets[1], [[2.5, 2.0], [5.0, 6.0]])
    np.testing.assert_allclose(sets[2], [[3.0, 2.0], [5.0, 6.0]])
    # At the interval's end the second jump takes no share of it.
    np.testing.assert_allclose(sets[3], [[3.0, 3.0], [5.0, 6.0]])
    np.testing.assert_allclose(sets[4], [[7.0, 8.0], [9.0, 9.0]])


def test_candidates_together_are_each_as_it_would_be_alone() -> None:
    rng = np.random.default_rng(2)
    shares, p = rng.random((7, 3)), rng.random((4, 7))
    event, row = np.array([0, 0, 1, 2]), np.array([1, 3, 1, 0])
    values = rng.random((4, 7))
    sets, along, there = scheduled(*moments(shares, T, 0.0), T, event, row, values, p)
    for lane in range(7):
        one = slice(lane, lane + 1)
        times = moments(shares[one], T, 0.0)
        alone = scheduled(*times, T, event, row, values[:, one].copy(), p[:, one].copy())
        for own, all_of_them in ((alone[1], along), (alone[2], there)):
            np.testing.assert_array_equal(alone[0][own][..., 0], sets[all_of_them][..., lane])


@pytest.mark.parametrize('earlier', [0, 1])
def test_a_value_after_a_jump_is_about_the_one_before(earlier: int) -> None:
    layout = Layout(2, ((1,), (0, 1)))
    point = np.array([0.1, 0.2, 0.5, 0.3, 0.5, 0.6, 0.7])
    point[layout.times[earlier]] = 0.2
    event, parameter, after = np.array([0, 1, 1]), np.array([1, 0, 1]), np.array([3, 5, 6])
    weight, prior = np.array([2.0, 3.0, 4.0]), (np.array([0.4, 0.5]), np.diag([6.0, 7.0]))
    mean, precision = normal(point, layout.times, event, parameter, after, weight, *prior)
    off = point - mean
    expected = 6.0 * 0.3**2 + 7.0 * 0.3**2
    weights = dict(zip(after.tolist(), weight.tolist(), strict=True))
    for jump in layout.jumped(point):
        expected += weights[jump.after] * (point[jump.after] - point[jump.before]) ** 2
        assert mean[jump.after] == mean[jump.before]
    middle = np.concatenate([point[:2] - prior[0], point[2:] - mean[2:]])
    np.testing.assert_array_equal(off, middle)
    np.testing.assert_array_equal(precision, precision.T)
    pull = 0.0
    for jump in layout.jumped(point):
        change = off[jump.after] - off[jump.before]
        pull += weights[jump.after] * change**2
    assert off @ precision @ off == pytest.approx(6.0 * off[0] ** 2 + 7.0 * off[1] ** 2 + pull)
    assert expected == pytest.approx(6.0 * 0.09 + 7.0 * 0.09 + pull)
