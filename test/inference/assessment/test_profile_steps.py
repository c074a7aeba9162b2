"""Tests of obs_ros.inference.assessment.profile_steps."""

import numpy as np
import pytest
from plants import LAG, lag_outputs
from scipy.optimize import lsq_linear

from obs_ros import Record, solve_window
from obs_ros.core.typing import Array
from obs_ros.horizon.solver import Solver
from obs_ros.inference.assessment.profile_steps import change, profile_steps, to_optimum

UNIT = np.array([np.zeros(4), np.ones(4)])


def least_squares_of(seed: int, d: int = 4) -> tuple[Array, Array, Array]:
    """A point (d,), a design (12, d) and residuals (12,)."""
    rng = np.random.default_rng([seed, 8])
    return rng.uniform(0.2, 0.8, d), rng.standard_normal((12, d)), rng.standard_normal(12)


@pytest.mark.parametrize('pinned', [-1, 2])
def test_the_optimum_of_the_others_is_that_of_scipy(pinned: int) -> None:
    """Seeds 0 to 9, limits so wide that none is met."""
    limits = np.array([np.full(4, -100.0), np.full(4, 100.0)])
    move = 0.0 if pinned < 0 else 0.15
    for seed in range(10):
        z, design, residual = least_squares_of(seed)
        free = np.zeros(4, dtype=np.bool_)
        found = to_optimum(
            z, design.T @ residual, design.T @ design, 0.0, pinned, move, limits, free
        )
        others = [i for i in range(4) if i != pinned]
        given = residual + (design[:, pinned] * move if pinned >= 0 else 0.0)
        expected = np.full(4, move)
        expected[others] = np.linalg.lstsq(design[:, others], -given, rcond=None)[0]
        np.testing.assert_allclose(found, expected, rtol=1e-8, atol=1e-10)
        np.testing.assert_array_equal(free, np.arange(4) != pinned)


def test_steps_stay_inside_the_limits_and_hardly_lose_by_that() -> None:
    """Against scipy's bounded least squares, seeds 0 to 49."""
    losses = []
    for seed in range(50):
        z, design, residual = least_squares_of(seed)
        gradient, hessian = design.T @ residual, design.T @ design
        free = np.zeros(4, dtype=np.bool_)
        step = to_optimum(z, gradient, hessian, 0.0, -1, 0.0, UNIT, free)
        assert (z + step >= 0.0).all() and (z + step <= 1.0).all()
        stopped = (z + step == 0.0) | (z + step == 1.0)
        np.testing.assert_array_equal(free, ~stopped)
        best = lsq_linear(design, design @ z - residual, (0.0, 1.0), method='bvls').x - z
        losses.append(
            (change(gradient, hessian, step) - change(gradient, hessian, best))
            / -change(gradient, hessian, best)
        )
    assert min(losses) > -1e-9
    assert np.median(losses) < 1e-9
    assert np.max(losses) < 0.3


def test_what_leans_outward_at_a_limit_stays_there() -> None:
    z, free = np.array([0.0, 1.0, 0.5, 0.5]), np.zeros(4, dtype=np.bool_)
    gradient = np.array([1.0, -1.0, 0.1, 0.0])
    step = to_optimum(z, gradient, np.eye(4), 0.0, -1, 0.0, UNIT, free)
    np.testing.assert_allclose(step, [0.0, 0.0, -0.1, 0.0])
    np.testing.assert_array_equal(free, [False, False, True, True])
    step = to_optimum(z, -gradient, np.eye(4), 0.0, -1, 0.0, UNIT, free)
    np.testing.assert_allclose(step, [1.0, -1.0, 0.1, 0.0])


def test_the_change_of_a_quadratic_cost() -> None:
    _, design, residual = least_squares_of(3)
    step = np.array([0.1, -0.2, 0.3, 0.05])
    expected = ((residual + design @ step) ** 2).sum() - (residual**2).sum()
    found = change(design.T @ residual, design.T @ design, step)
    assert found == pytest.approx(expected, rel=1e-12)


def steps(
    z: Array, design: Array, residual: Array, side: float, **changes: float
) -> tuple[Array, ...]:
    """Steps of each unknown's lane to one side, from the same point z (d,)."""
    d = z.size
    most = {'radius': 100.0, 'damping': 0.0, 'least': 0.0, 'growth': 3.84, **changes}
    squares = np.full(d, float(residual @ residual))
    gradient = np.tile(design.T @ residual, (d, 1))
    hessian = np.tile(design.T @ design, (d, 1, 1))
    limits = np.array([np.full(d, -100.0), np.full(d, 100.0)])
    return profile_steps(
        np.tile(z, (d, 1)), squares, gradient, hessian, np.arange(d), np.full(d, side),
        np.full(d, most['radius']), np.full(d, most['damping']), most['least'], most['growth'],
        0.5, limits,
    )  # fmt: skip


@pytest.mark.parametrize('side', [-1.0, 1.0])
def test_one_step_from_an_optimum_reaches_the_ends_of_a_parabola(side: float) -> None:
    z, design, noise = least_squares_of(5)
    residual = noise - design @ np.linalg.lstsq(design, noise, rcond=None)[0]
    least = float(residual @ residual)
    step, excess, foretold = steps(z, design, residual, side, least=least)
    covariance = np.linalg.inv(design.T @ design)
    deviations = np.sqrt(np.diagonal(covariance))
    expected = side * np.sqrt(3.84) * covariance / deviations[:, None]
    np.testing.assert_allclose(step, expected, rtol=1e-6)
    np.testing.assert_allclose(excess, 0.0, atol=1e-9)
    np.testing.assert_allclose(foretold, least + 3.84, rtol=1e-9)


def test_no_unknown_moves_further_than_the_radius() -> None:
    z, design, noise = least_squares_of(5)
    residual = noise - design @ np.linalg.lstsq(design, noise, rcond=None)[0]
    step = steps(z, design, residual, 1.0, least=float(residual @ residual), radius=0.03)[0]
    assert np.abs(step).max() <= 0.03 * (1.0 + 1e-9)
    np.testing.assert_allclose(np.diagonal(step), 0.03, rtol=1e-9)


def test_far_above_its_valley_a_lane_goes_down_first() -> None:
    z, design, residual = least_squares_of(7)
    gained = float(residual @ residual) - np.linalg.lstsq(design, residual, rcond=None)[1][0]
    assert gained > 3.84  # what is to gain is more than the level
    step, excess, _ = steps(z, design, residual, 1.0, growth=0.5)
    for k in range(4):
        others = np.delete(np.arange(4), k)
        down = np.linalg.lstsq(design[:, others], -residual, rcond=None)[0]
        np.testing.assert_allclose(step[k, others], down, rtol=1e-6)
        left = residual + design[:, others] @ down
        assert excess[k] == pytest.approx(residual @ residual - left @ left, rel=1e-6)


def test_everything_is_compiled_before_the_clock_starts() -> None:
    """A step response that is cut off has a bent valley: its window needs profiles."""
    pytest.importorskip('numba')
    functions = (change, profile_steps, to_optimum)
    Solver.of(LAG).prepare()
    compiled = [set(function.signatures) for function in functions]
    assert all(compiled)
    t = 0.2 * np.arange(41)
    y = lag_outputs(t, np.ones(41), 0.0, np.tile([1.5, 9.0], (41, 1)))
    y += 0.05 * np.random.default_rng(4).standard_normal(41)
    found = solve_window(LAG, Record(t, np.ones(41), y), noise={'y': 0.05})
    k = found.parameters['k']
    lower, upper = found.interval['k']
    assert upper - k > 1.2 * (k - lower)
    assert [set(function.signatures) for function in functions] == compiled
