"""Tests of obs_ros.optimization.levenberg_marquardt, against scipy."""

from collections.abc import Callable

import numpy as np
import pytest
from problems import Curve, decay, decay_problem, ripples_problem
from scipy.optimize import least_squares, lsq_linear

from obs_ros.core.deadline import Deadline
from obs_ros.core.typing import Array
from obs_ros.optimization.levenberg_marquardt import (
    LMSettings,
    Starts,
    levenberg_marquardt,
    optimum_width,
)

NEVER = Deadline()


def scipy_optimum(problem: Curve, z0: Array) -> tuple[Array, float]:
    result = least_squares(
        lambda z: problem.errors(z[None])[0], z0, bounds=(0.0, 1.0),
        xtol=1e-15, ftol=1e-15, gtol=1e-15, x_scale='jac', max_nfev=2000,
    )  # fmt: skip
    return result.x, 2.0 * result.cost


def linear(a: Array) -> Callable[[Array, Array], Array]:
    return lambda z, s: z @ a.T


@pytest.mark.parametrize('seed', range(5))
def test_inside_the_box_it_finds_the_optimum_of_scipy(seed: int) -> None:
    rng = np.random.default_rng(seed)
    problem = decay_problem(tuple(rng.uniform(0.25, 0.75, 3)), seed=seed)
    starts = rng.uniform(0.1, 0.9, (4, 3))
    found = levenberg_marquardt(problem, starts, 200, 60, NEVER)
    _, best = scipy_optimum(problem, starts[0])
    # Convergence promises a gain left below 1 % of d times the noise variance.
    np.testing.assert_allclose(found.squares, best, rtol=0.0, atol=0.02 * 3 * best / 197)
    assert found.converged.all()
    assert found.squares.min() >= best * (1.0 - 1e-9)


@pytest.mark.parametrize('truth', [(1.2, 0.4, 0.2), (0.7, 1.3, 0.2), (0.7, 0.4, -0.2)])
def test_an_optimum_at_a_bound(truth: tuple[float, float, float]) -> None:
    problem = decay_problem(truth)
    found = levenberg_marquardt(problem, np.full((1, 3), 0.5), 200, 60, NEVER)
    z, best = scipy_optimum(problem, np.full(3, 0.5))
    assert found.squares[0] == pytest.approx(best, rel=1e-3)
    np.testing.assert_allclose(found.z[0], z, atol=5e-3)
    at_bound = np.argmax(np.abs(np.array(truth) - 0.5))
    assert found.z[0, at_bound] in (0.0, 1.0)


def test_linear_problems_with_many_active_bounds() -> None:
    rng = np.random.default_rng(11)
    for _ in range(30):
        a = rng.standard_normal((12, 5))
        y = a @ rng.uniform(-1.0, 2.0, 5) + 0.1 * rng.standard_normal(12)
        problem = Curve(linear(a), np.arange(12.0), y, 5)
        found = levenberg_marquardt(problem, rng.random((3, 5)), 12, 60, NEVER)
        best = 2.0 * lsq_linear(a, y, (0.0, 1.0), tol=1e-13).cost
        assert best - 1e-9 <= found.squares[0] <= best + 0.05 * 5 * best / 7


@pytest.mark.parametrize('count', [250, pytest.param(1000, marks=pytest.mark.slow)])
def test_converged_means_that_little_is_left_to_gain_even_at_bounds(count: int) -> None:
    """Ill-conditioned, since a frozen bound may come free at the Gauss-Newton point."""
    rng = np.random.default_rng(0)
    converged = 0
    for problem_number in range(count):
        d = rng.integers(2, 7)
        m = d + rng.integers(1, 10)
        rotation = np.linalg.qr(rng.standard_normal((d, d)))[0]
        a = rng.standard_normal((m, d)) @ np.diag(10.0 ** rng.uniform(-2.0, 1.0, d)) @ rotation
        y = a @ rng.uniform(-0.5, 1.5, d) + 0.1 * rng.standard_normal(m)
        problem = Curve(linear(a), np.arange(float(m)), y, d)
        found = levenberg_marquardt(problem, rng.random((1, d)), m, 60, NEVER)
        best = 2.0 * lsq_linear(a, y, (0.0, 1.0), tol=1e-14).cost
        if found.converged[0]:
            converged += 1
            # Less than what tells two optima apart, LMSettings.same_optimum.
            assert found.squares[0] - best < 0.1025 * d * best / (m - d), problem_number
    assert converged > 0.95 * count


def test_an_unknown_without_effect_stays_and_does_not_overflow() -> None:
    s = np.linspace(0.0, 1.0, 50)
    problem = Curve(lambda z, s: 1e6 * z[:, :1] * s, s, 1e6 * (0.3 * s + s * s), 2)
    found = levenberg_marquardt(problem, np.array([[0.5, 0.4]]), 50, 60, NEVER)
    _, best = scipy_optimum(problem, np.full(2, 0.5))
    assert found.squares[0] == pytest.approx(best, rel=1e-3)
    assert found.z[0].tolist() == [1.0, 0.4]


def test_a_start_at_the_wrong_bounds_comes_free() -> None:
    problem = decay_problem()
    _, best = scipy_optimum(problem, np.full(3, 0.5))
    for corner in ([0.0, 0.0, 0.0], [1.0, 1.0, 1.0], [0.0, 1.0, 1.0], [1.0, 0.0, 0.0]):
        found = levenberg_marquardt(problem, np.array([corner]), 200, 100, NEVER)
        assert found.squares[0] == pytest.approx(best, rel=1e-3), corner


def test_a_singular_jacobian_leaves_the_free_direction_where_it_was() -> None:
    rng = np.random.default_rng(3)
    s = np.linspace(0.0, 1.0, 50)
    y = np.exp(-0.8 * s) + 0.01 * rng.standard_normal(50)
    problem = Curve(lambda z, s: np.exp(-(z[:, :1] + z[:, 1:2]) * s), s, y, 3)
    found = levenberg_marquardt(problem, np.array([[0.3, 0.2, 0.9]]), 50, 60, NEVER)
    one = Curve(lambda z, s: np.exp(-2.0 * z[:, :1] * s), s, y, 1)
    assert found.squares[0] == pytest.approx(scipy_optimum(one, np.array([0.5]))[1], rel=1e-3)
    assert found.z[0, 0] - found.z[0, 1] == pytest.approx(0.1, abs=1e-6)
    assert found.z[0, 2] == pytest.approx(0.9, abs=1e-6)


def test_without_noise_it_goes_down_to_rounding() -> None:
    problem = decay_problem(sigma=0.0)
    found = levenberg_marquardt(problem, np.full((1, 3), 0.5), 200, 60, NEVER)
    np.testing.assert_allclose(found.z[0], (0.7, 0.4, 0.2), atol=1e-8)


def test_a_curved_valley() -> None:
    def valley(z: Array, s: Array) -> Array:
        a, b = 4.0 * z.T - 2.0
        return np.stack([1.0 - a, 10.0 * (b - a * a)], axis=1)

    problem = Curve(valley, np.arange(2.0), np.zeros(2), 2)
    found = levenberg_marquardt(problem, np.array([[0.2, 0.75]]), 2, 100, NEVER)
    np.testing.assert_allclose(found.z[0], 0.75, atol=1e-6)


def test_false_minima_are_left_to_the_other_starts_and_the_best_comes_first() -> None:
    problem = ripples_problem()
    starts = np.column_stack([np.linspace(0.02, 0.98, 40), np.full(40, 0.5)])
    found = levenberg_marquardt(problem, starts, 300, 60, NEVER)
    assert (np.diff(found.squares) >= 0.0).all()
    np.testing.assert_allclose(found.z[0], (0.63, 0.3), atol=0.01)
    np.testing.assert_allclose(found.squares, problem.costs(found.z), rtol=1e-12)


def test_every_start_ends_no_worse_than_it_began_and_inside_the_box() -> None:
    problem = ripples_problem()
    for start in np.random.default_rng(4).random((20, 2)):
        begun = problem.costs(start[None])[0]
        found = levenberg_marquardt(problem, start[None], 300, 60, NEVER)
        assert found.squares[0] <= begun
        assert found.z.min() >= 0.0 and found.z.max() <= 1.0


def test_starts_do_not_disturb_each_other_and_a_diverged_one_comes_last() -> None:
    def curve(z: Array, s: Array) -> Array:
        values = decay(z, s)
        values[z[:, 0] > 0.95] = np.nan
        return values

    plain = decay_problem()
    problem = Curve(curve, plain.s, plain.y, 3)
    good, bad = np.array([[0.5, 0.5, 0.5]]), np.array([[0.99, 0.5, 0.5]])
    alone = levenberg_marquardt(problem, good, 200, 60, NEVER)
    both = levenberg_marquardt(problem, np.vstack([bad, good]), 200, 60, NEVER)
    np.testing.assert_allclose(both.z[0], alone.z[0], rtol=1e-12)
    assert not np.isfinite(both.squares[1])
    assert not both.converged[1]


@pytest.mark.parametrize('deadline', [Deadline(0.0), NEVER])
def test_without_time_or_iterations_the_starts_come_back(deadline: Deadline) -> None:
    problem = decay_problem()
    starts = np.array([[0.9, 0.1, 0.9], [0.6, 0.5, 0.3]])
    found = levenberg_marquardt(problem, starts, 200, 0 if deadline is NEVER else 60, deadline)
    np.testing.assert_array_equal(found.z, starts[::-1])
    assert not found.converged.any()


def test_only_the_prefix_counts() -> None:
    problem = decay_problem()
    half = Curve(decay, problem.s[:100], problem.y[:100], 3)
    start = np.full((1, 3), 0.5)
    a = levenberg_marquardt(problem, start, 100, 60, NEVER)
    b = levenberg_marquardt(half, start, 100, 60, NEVER)
    np.testing.assert_allclose(a.z, b.z, rtol=1e-12)


def test_only_what_has_converged_within_the_width_of_an_optimum_agrees() -> None:
    """Squares of one optimum differ by less than 0.1025 d times the noise's variance."""
    width = optimum_width(decay_problem(nodes=103), 100.0)
    assert width == pytest.approx(0.1025 * 3.0 * 1.0)
    assert optimum_width(decay_problem(nodes=103), 100.0, LMSettings(same_optimum=1.0)) == 3.0
    for above, converged, agreeing in ((0.9, True, 2), (1.1, True, 1), (0.0, False, 1)):
        squares = np.array([100.0, 100.0 + above * width])
        ends = Starts(np.full((2, 3), 0.5), squares, np.array([True, converged]))
        assert ends.agreeing(100.0, width) == agreeing
