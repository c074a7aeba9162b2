"""Tests of obs_ros.inference.jumps.screening."""

from dataclasses import replace

import numpy as np
import pytest
from jump_windows import (
    DESIGN,
    DRIFT,
    GAIN,
    LOWER,
    SIGMA,
    TIGHT,
    T,
    U,
    changed,
    neg2_log_probability,
    record,
    still,
    with_a_drift_jump,
)
from plants import integrator_design

from obs_ros.inference.jumps.screening import (
    at_nodes,
    screen,
    screen_earlier,
    time_averages,
    widened,
)
from obs_ros.inference.prior import Prior


@pytest.mark.parametrize('jump', [0.0, 0.6])
def test_gains_of_jumps_sought_to_first_order(jump: float) -> None:
    window = record(jump)
    base = still(window, TIGHT)
    times = np.array([0.125, 0.4237, 0.875])
    _, gains, sizes = screen(base, [GAIN, DRIFT], times)
    without = neg2_log_probability(window, prior=TIGHT)
    # Screened jumps begin at nodes.
    for i, time in enumerate(10.0 * at_nodes(T, times)):
        for j, place in enumerate((GAIN, DRIFT)):
            shape = changed(time, place)
            gain = without - neg2_log_probability(window, shape, prior=TIGHT)
            assert gains[i, j] == pytest.approx(gain, abs=2e-3, rel=1e-4)
            joint = np.column_stack([DESIGN, shape])
            before = np.zeros((4, 4))
            before[:3, :3], before[3, 3] = TIGHT.precision, 12.0
            target = (window.y[:, 0] - integrator_design(T, U) @ LOWER) / SIGMA
            off = target - DESIGN @ TIGHT.mean
            best = np.linalg.solve(joint.T @ joint + before, joint.T @ off)
            assert sizes[i, j] == pytest.approx(best[3], abs=1e-4)


def test_the_gain_of_a_second_jump_beside_one() -> None:
    base = with_a_drift_jump(record(0.6), TIGHT)
    _, gains, _ = screen(base, [GAIN], np.array([0.8]))
    # Its time is as free as its size: another column, of the slope there.
    h = 1e-6
    time = 10.0 * base.point[3]
    size = base.point[4] - base.point[2]
    slope = (changed(time + h, DRIFT) - changed(time - h, DRIFT)) / (2.0 * h) * 10.0 * size
    columns = np.column_stack([DESIGN, changed(time, DRIFT), slope, changed(8.0, GAIN)])
    before = np.zeros((6, 6))
    before[:3, :3] = TIGHT.precision
    before[3, 3] = before[4, 4] = before[5, 5] = 12.0
    residual = base.linearisation.residual
    joint = columns.T @ columns + before
    score = columns[:, 5] @ residual
    schur = joint[5, 5] - joint[5, :5] @ np.linalg.solve(joint[:5, :5], joint[:5, 5])
    assert gains[0, 0] == pytest.approx(score**2 / schur - np.log(schur / 12.0), rel=1e-3)


def test_the_gain_of_a_jump_before_the_window() -> None:
    for mean in (0.31, 0.45):
        prior = Prior(np.array([0.5, 0.64, mean]), TIGHT.precision)
        window = record()
        base = still(window, prior)
        gains, _ = screen_earlier(base, [GAIN, DRIFT])
        covariance = np.linalg.inv(TIGHT.precision)
        covariance[DRIFT, DRIFT] += 1.0 / 12.0
        wider = replace(prior, precision=np.linalg.inv(covariance))
        narrow, wide = (neg2_log_probability(window, prior=p) for p in (prior, wider))
        assert gains[1] == pytest.approx(narrow - wide, abs=1e-3)


def test_the_squares_that_a_jump_before_the_window_would_have_saved() -> None:
    prior = Prior(np.array([0.5, 0.64, 0.45]), TIGHT.precision)
    base = still(record(), prior)
    wider = widened(prior, base.problem.objective.unknowns, DRIFT)
    design, off = DESIGN, (record().y[:, 0] - integrator_design(T, U) @ LOWER) / SIGMA
    information = design.T @ design + wider.precision
    covariance = np.linalg.inv(information)
    point = covariance @ (design.T @ off + wider.precision @ wider.mean)
    size = point[DRIFT] - 0.45
    _, squares = screen_earlier(base, [GAIN, DRIFT])
    assert squares[1] == pytest.approx(size**2 / covariance[DRIFT, DRIFT], rel=1e-2)
    assert squares[1] > 100.0 * squares[0]


def test_widened_by_the_variance_of_a_box_and_no_further() -> None:
    unknowns = still(record()).problem.objective.unknowns
    found = np.linalg.inv(widened(TIGHT, unknowns, DRIFT).precision)[1:, 1:]
    assert found[0, 0] == pytest.approx(4e-4, rel=0.01)
    assert found[1, 1] == pytest.approx(1.0 / 12.0, rel=0.01)
    both = np.linalg.inv(widened(TIGHT, unknowns, GAIN, DRIFT).precision)[1:, 1:]
    np.testing.assert_allclose(np.diagonal(both), 1.0 / 12.0, rtol=0.02)
    np.testing.assert_array_equal(widened(TIGHT, unknowns, DRIFT).mean, TIGHT.mean)


def test_widened_it_keeps_what_is_given() -> None:
    unknowns = still(record()).problem.objective.unknowns
    given = replace(TIGHT, given=np.array([0.0, 50.0, 0.0]))
    np.testing.assert_array_equal(widened(given, unknowns, DRIFT).given, given.given)


def test_a_gain_counts_by_the_share_of_the_window_in_which_a_jump_has_it() -> None:
    gains = np.array([[8.0, -np.inf, 2e3], [0.0, -np.inf, 0.0], [0.0, -np.inf, 0.0]])
    found = time_averages(np.array([0.0, 0.5, 0.75]), gains)
    expected = 2.0 * np.log(0.5 * np.exp(4.0) + 0.5)
    np.testing.assert_allclose(found[[0, 2]], [expected, 2e3 + 2.0 * np.log(0.5)])
    assert found[1] < -1e300
