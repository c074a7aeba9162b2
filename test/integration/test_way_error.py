"""Tests of obs_ros.integration.way_error: errors by hand."""

import numpy as np
import pytest

from obs_ros.integration.path import LANES
from obs_ros.integration.way_error import (
    NOWHERE,
    Scales,
    Way,
    WayError,
    judged,
    leapt,
    strayed,
    widened,
)

NAN = np.nan


def way(x: float = 1.0, y: float = 2.0) -> Way:
    """Candidates of two states and two outputs, the fine way at x and y."""
    found = Way.of(2, 2, LANES)
    for array, value in zip(found, (0.0, x, y, y), strict=True):
        array[:] = value
    return found


def scales(
    noise: tuple[float, float] = (0.1, 0.1),
    stddev: tuple[float, float] = (NAN, NAN),
    period: tuple[float, float] = (0.0, 0.0),
) -> Scales:
    arrays = (np.array(values) for values in (noise, stddev, period))
    return Scales(
        *arrays, np.array([1.0, 2.0]), share=0.01, sensitivity=0.1, unknown_noise=1e-3,
        rounding=1e-9, lost=1e6,
    )  # fmt: skip


def test_errors_are_in_units_of_the_noise_s_share() -> None:
    """Output 0 of lane 0 is off by 0.05 of its noise, of lane 3 by 0.2: five and twenty shares."""
    found = way()
    found.y[0, 0] += 0.005
    found.y[0, 3] -= 0.02
    error = WayError(*judged(found, scales(), found.fine.copy()))
    assert error.diverged == 0
    assert error.worst == pytest.approx(20.0)
    assert error.sd == pytest.approx(0.05)  # of the mean, in lane 0
    assert not error.within


def test_states_count_where_their_deviation_is_known() -> None:
    found = way()
    x = found.fine.copy()
    x[1] += 1e-3
    assert WayError(*judged(found, scales(), x)).worst == 0.0
    known = scales(stddev=(NAN, 0.2))
    assert WayError(*judged(found, known, x)).worst == pytest.approx(0.5)


def test_an_output_of_unknown_noise_errs_by_a_share_of_its_value() -> None:
    found = way(y=50.0)
    found.y[1] += 1e-4
    error = WayError(*judged(found, scales(noise=(0.1, NAN)), found.fine.copy()))
    assert error.worst == pytest.approx(1e-4 / (0.01 * 1e-3 * 50.0))


def test_no_error_is_asked_for_that_rounding_hides() -> None:
    found = way(y=1e6)
    found.y[0] += 1e-4
    error = WayError(*judged(found, scales(noise=(1e-6, 1.0)), found.fine.copy()))
    assert error.worst == pytest.approx(0.1)


def test_outputs_that_wrap_differ_by_the_shortest_way() -> None:
    found = way(y=-3.0)
    found.y[0] += 6.0
    error = WayError(*judged(found, scales(period=(6.0, 0.0)), found.fine.copy()))
    assert error.worst == 0.0


def test_candidates_that_diverge_are_counted_and_hide_no_other() -> None:
    found = way()
    x = found.fine.copy()
    x[0, 2], found.y[1, 7], found.y[1, 8] = NAN, np.inf, 1e4
    found.y[0, 1] += 2e-3
    error = WayError(*judged(found, scales(), x))
    assert (error.diverged, error.worst) == (3, pytest.approx(2.0))
    assert WayError(0, 1e9, 0.0) < error  # diverging is worse than anything
    assert error.comparable(WayError(3, 0.6, 0.0))
    assert not error.comparable(WayError(1, 0.6, 0.0))
    assert error._replace(worst=1.0).comparable(WayError(3, 1e-9, 0.0))  # it is enough


def test_what_a_candidate_is_off_another_errs_by_a_share_of_that() -> None:
    """Candidate 4 starts 1e-3 off in a state of size 2, and ends 3e-4 or 2e-4 off in another."""
    found = way()
    found.start[1, 4] += 1e-3
    found.fine[0, 4] += 2e-4
    x = found.fine.copy()
    x[0, 4] += 1e-4
    error = WayError(*judged(found, scales(), x))
    assert error.worst == pytest.approx(1e-4 / (0.1 * 5e-4))


def test_a_region_grows_by_ways_and_shows_who_leaves_it() -> None:
    region, margin = np.empty((2, 1)), np.array([0.5])
    region[:] = NOWHERE
    start, x = np.full((1, LANES), 1.0), np.full((1, LANES), 3.0)
    one = np.ones(1)
    steps = one.astype(np.int64)
    assert strayed(region, x, 1, one, steps, 1.0)
    widened(region, margin, start, x)
    assert region[:, 0] == pytest.approx([0.3, 3.7])
    assert not strayed(region, x, 1, one, steps, 1.0)
    x[0, 9] = 3.8
    assert strayed(region, x, 1, one, steps, 1.0)
    x[0, 9] = NAN
    assert strayed(region, x, 1, one, steps, 1.0)


def test_a_step_longer_than_those_compared_strays() -> None:
    region = np.array([[-1.0], [1.0]])
    x, dt = np.zeros((1, LANES)), np.array([0.1, 0.4])
    assert not strayed(region, x, 2, dt, np.array([1, 4]), 0.1)
    assert strayed(region, x, 2, dt, np.array([1, 3]), 0.1)
    assert not strayed(region, x, 1, dt, np.array([1, 3]), 0.1)


def test_inputs_leap_where_pieces_begin() -> None:
    leap, seen, last = np.zeros(2), np.array([1.0, 0.1]), np.full(2, np.nan)
    dt, slope = np.array([0.5, 0.5]), np.array([[2.0, 0.0], [0.0, 0.0], [0.0, 0.0]])
    # The first input rises by a ramp and leaps by 0.5 at its end; the last row acts no more.
    u = np.array([[1.0, 3.0], [2.5, 3.0], [9.0, 9.0]])
    assert not leapt(leap, seen, last, 2, dt, u, slope)
    np.testing.assert_allclose(leap, [0.5, 0.0])
    np.testing.assert_allclose(last, [2.5, 3.0])
    assert leapt(leap, seen, last, 1, dt, np.array([[2.5, 3.2], [0.0, 0.0]]), 0.0 * slope)
    np.testing.assert_allclose(leap, [0.0, 0.2])
