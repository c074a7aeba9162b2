"""Tests of obs_ros.inference.assessment.profile."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from plants import LAG, lag_outputs, window_of
from problems import linear, rows_of
from scipy.optimize import brentq, least_squares, minimize

from obs_ros import Model, Record, Variable
from obs_ros.core.deadline import Deadline
from obs_ros.core.typing import Array
from obs_ros.inference.assessment.interval import enlarged
from obs_ros.inference.assessment.profile import Ends, profile_ends
from obs_ros.inference.jumps.piecewise import PiecewiseProblem
from obs_ros.inference.prior import Posterior, Prior
from obs_ros.optimization.levenberg_marquardt import levenberg_marquardt

LEVEL = 3.84
PROBE = 1e-6


def ends_of(posterior: Any, z: Array, deadline: Deadline | None = None, reach: float = 1.0) -> Ends:
    pinned = np.arange(z.size)
    whole = np.full(z.size, reach)
    return profile_ends(posterior, z, pinned, whole, LEVEL, PROBE, deadline or Deadline())


def values(ends: Ends) -> Array:
    """Lower and upper ends (2, q)."""
    found = ends.points[np.arange(ends.pinned.size), ends.pinned]
    return found.reshape(2, -1)


def optimum(posterior: Any, start: Array) -> Array:
    found = levenberg_marquardt(posterior, start[None], posterior.nodes, 100, Deadline())
    return np.asarray(found.z[0])


class TestStraight:
    def test_ends_are_those_of_the_parabola_in_few_rollouts(self) -> None:
        """Seeds 0 to 9; beside the whole point at each end."""
        for seed in range(10):
            posterior, z, covariance = linear(seed)
            posterior.evaluations = 0
            ends = ends_of(posterior, z)
            off = np.sqrt(LEVEL) * covariance / np.sqrt(np.diagonal(covariance))[:, None]
            np.testing.assert_allclose(ends.points, z + np.vstack([-off, off]), atol=1e-4)
            np.testing.assert_array_equal(ends.pinned, [0, 1, 2, 3, 0, 1, 2, 3])
            np.testing.assert_array_equal(ends.growth, LEVEL)
            assert ends.closed.all() and ends.better is None
            np.testing.assert_allclose(ends.middle, z, atol=1e-6)
            # A linearisation takes 1 + 2 d here; 6 iterations of 2 d lanes at most.
            assert posterior.evaluations <= (1 + 6 * 8) * 9

    def test_from_beside_the_optimum_the_middle_is_the_optimum(self) -> None:
        posterior, z, covariance = linear(1)
        off = 0.2 * np.sqrt(np.diagonal(covariance)) * [1.0, -1.0, 1.0, -1.0]
        ends, exact = ends_of(posterior, z + off), ends_of(posterior, z)
        np.testing.assert_allclose(ends.middle, z, atol=1e-5)
        np.testing.assert_allclose(values(ends), values(exact), atol=1e-3)


def product(weak: float, strong: float = 0.01) -> Any:
    """Of a and b the product is known to `strong`, and a to `weak`: a hyperbola of low cost."""
    return rows_of(lambda z: [(z[:, 0] * z[:, 1] - 0.25) / strong, (z[:, 0] - 0.5) / weak])


class TestBent:
    def test_ends_on_a_hyperbola(self) -> None:
        """With b given a is found in closed form: (b / 2 - 1/4)^2 = 3.84 (strong^2 + weak^2 b^2).

        With a given b = 1 / (4 a) costs nothing.
        """
        weak, strong = 0.12, 0.01
        posterior, z = product(weak, strong), np.array([0.5, 0.5])
        ends = ends_of(posterior, z)
        square = [0.25 - LEVEL * weak**2, -0.25, 0.0625 - LEVEL * strong**2]
        b = np.sort(np.roots(square))
        half = np.sqrt(LEVEL) * weak
        assert ends.closed.all()
        np.testing.assert_allclose(
            values(ends), [[0.5 - half, b[0]], [0.5 + half, b[1]]], atol=2e-3
        )
        assert b[1] - 0.5 > 2.5 * (0.5 - b[0])  # it is bent
        np.testing.assert_allclose(ends.points[0, 1], 0.25 / (0.5 - half), atol=5e-3)

    def test_at_a_bound_a_profile_is_open(self) -> None:
        """At b = 1 the cost has grown by (1/4)^2 / (strong^2 + weak^2), at a = 1 by that of a.

        At their lower ends the other one lies at its bound.
        """
        weak, strong = 0.3, 0.02
        ends = ends_of(product(weak, strong), np.array([0.5, 0.5]))
        np.testing.assert_array_equal(ends.closed, [True, True, False, False])
        np.testing.assert_array_equal(values(ends)[1], 1.0)
        expected = [(0.5 / weak) ** 2, 0.0625 / (strong**2 + weak**2)]
        np.testing.assert_allclose(ends.growth[2:], expected, rtol=0.05)

        def of_a(a: float) -> float:  # b stays at its bound
            return float(((a - 0.25) / strong) ** 2 + ((a - 0.5) / weak) ** 2 - LEVEL)

        b = 0.25 - strong * np.sqrt(LEVEL - (0.5 / weak) ** 2)
        lower = [brentq(of_a, 0.0, 0.25), b]
        np.testing.assert_allclose(values(ends)[0], lower, atol=2e-3)

    def test_further_than_its_reach_no_profile_is_followed(self) -> None:
        """But for one step."""
        ends = ends_of(product(0.12), np.array([0.5, 0.5]), reach=0.1)
        assert not ends.closed[3]
        assert 0.6 < values(ends)[1, 1] <= 0.9

    def test_without_time_nothing_is_closed(self) -> None:
        ends = ends_of(product(0.12), np.array([0.5, 0.5]), Deadline(0.0))
        assert not ends.closed.any() and ends.better is None
        assert np.isfinite(ends.points).all()


def two_valleys(tilt: float) -> Any:
    """At b = .2 a is .4, beyond b = .65 it is .7; between lies a ridge below the level.

    The second valley costs tilt^2 more than the first one, or as much less where it is negative.
    """

    def residuals(z: Array) -> list[Array]:
        a, b = z.T
        middle = 0.4 + 0.3 / (1.0 + np.exp(-(b - 0.65) / 0.02))
        leaning = tilt * (b - 0.2) / 0.6 if tilt > 0.0 else tilt * (b - 0.8) / 0.6
        return [(a - middle) / 0.03, (b - 0.2) * (b - 0.8) / 0.06, leaning]

    return rows_of(residuals)


class TestBranches:
    def test_a_lane_goes_on_from_where_another_shows_its_end_too_early(self) -> None:
        """a alone ends at .46; on its way b finds the second valley. Truth on a fine grid of b."""
        posterior = two_valleys(0.8)
        ends = ends_of(posterior, np.array([0.4, 0.2]))
        b = np.linspace(0.0, 1.0, 200001)
        middle = 0.4 + 0.3 / (1.0 + np.exp(-(b - 0.65) / 0.02))
        rest = LEVEL - ((b - 0.2) * (b - 0.8) / 0.06) ** 2 - (0.8 * (b - 0.2) / 0.6) ** 2
        half = 0.03 * np.sqrt(np.maximum(rest, 0.0))
        allowed = rest >= 0.0
        lower, upper = (middle - half)[allowed].min(), (middle + half)[allowed].max()
        assert ends.closed.all()
        assert upper > 0.7
        np.testing.assert_allclose(values(ends)[:, 0], [lower, upper], atol=5e-3)
        np.testing.assert_allclose(
            values(ends)[:, 1], [b[allowed].min(), b[allowed].max()], atol=5e-3
        )

    def test_other_optima_show_how_far_an_unknown_may_go(self) -> None:
        """A ridge above the level, which no lane crosses, hides the second valley."""
        ridge = 0.09 / 2.3

        def residuals(z: Array) -> list[Array]:
            a, b = z.T
            return [(a - 0.4 - 0.5 * (b - 0.2)) / 0.03, (b - 0.2) * (b - 0.8) / ridge]

        posterior, z = rows_of(residuals), np.array([0.4, 0.2])
        alone = ends_of(posterior, z)
        assert alone.closed.all() and values(alone)[1, 1] < 0.5
        whole, pinned = np.ones(2), np.arange(2)
        others = np.array([[0.7, 0.8], [0.1, 0.9]])
        ends = profile_ends(posterior, z, pinned, whole, LEVEL, PROBE, Deadline(), others)
        b = np.linspace(0.0, 1.0, 200001)
        rest = LEVEL - ((b - 0.2) * (b - 0.8) / ridge) ** 2
        allowed = rest >= 0.0
        upper = (0.4 + 0.5 * (b - 0.2) + 0.03 * np.sqrt(np.maximum(rest, 0.0)))[allowed].max()
        assert ends.closed.all()
        np.testing.assert_allclose(values(ends)[1], [upper, b[allowed].max()], atol=5e-3)
        np.testing.assert_allclose(values(ends)[0], values(alone)[0], atol=2e-3)

    def test_a_better_optimum_is_met(self) -> None:
        posterior = two_valleys(-1.7)
        start = optimum(posterior, np.array([0.4, 0.2]))
        assert start[1] < 0.4
        ends = ends_of(posterior, start)
        assert ends.better is not None
        costs = posterior.costs(np.array([start, ends.better]))
        assert costs[1] < costs[0] - 0.5
        assert optimum(posterior, ends.better)[1] > 0.6


class TestPlants:
    T = 0.2 * np.arange(41)
    SIGMA = 0.03

    def lag(self, backend: Any) -> tuple[Posterior, Callable[[Array], Array]]:
        """A step response, cut off before it is over, and its residuals (K + 3,) in closed form."""
        t, sigma = self.T, self.SIGMA
        u = np.ones(t.size)
        noise = sigma * np.random.default_rng(4).standard_normal(t.size)
        y = lag_outputs(t, u, 0.0, np.tile([1.5, 9.0], (t.size, 1))) + noise
        objective = window_of(LAG, Record(t, u, y), sigma, backend)
        prior = Prior.box(objective.unknowns).knowledge

        def residuals(z: Array) -> Array:
            x0, k, tau = objective.unknowns.scale.values(z)
            found = lag_outputs(t, u, x0, np.tile([k, tau], (t.size, 1)))
            weak = np.sqrt(np.diagonal(prior.precision)) * (z - prior.mean)
            return np.append((found - y) / sigma, weak)

        return Posterior(objective, prior), residuals

    def test_ends_are_those_that_scipy_finds(self, backend: str) -> None:
        posterior, residuals = self.lag(backend)
        start = posterior.objective.unknowns.point({'x': 0.0, 'k': 1.5, 'tau': 9.0})
        z = optimum(posterior, start)
        least = float((residuals(z) ** 2).sum())

        def growth(value: float, k: int) -> float:
            others = np.delete(np.arange(3), k)

            def part(w: Array) -> Array:
                return residuals(np.insert(w, k, value))

            found = least_squares(part, z[others], bounds=(0.0, 1.0), xtol=1e-12, ftol=1e-12)
            return 2.0 * float(found.cost) - least - LEVEL

        ends = ends_of(posterior, z)
        assert ends.closed.all()
        for k in range(3):
            lower = brentq(growth, z[k] - 0.45 * z[k], z[k], args=(k,), xtol=1e-6)
            upper = brentq(growth, z[k], z[k] + 0.9 * (1.0 - z[k]), args=(k,), xtol=1e-6)
            width = upper - lower
            np.testing.assert_allclose(values(ends)[:, k], [lower, upper], atol=0.02 * width)

    def test_both_backends_find_the_same(self) -> None:
        pytest.importorskip('numba')
        found = []
        for backend in ('numpy', 'numba'):
            posterior, _ = self.lag(backend)
            start = posterior.objective.unknowns.point({'x': 0.0, 'k': 1.5, 'tau': 9.0})
            found.append(ends_of(posterior, optimum(posterior, start)))
        np.testing.assert_allclose(found[1].points, found[0].points, atol=1e-4)
        np.testing.assert_array_equal(found[1].closed, found[0].closed)

    def test_near_an_optimum_the_model_may_diverge(self, backend: str) -> None:
        """x = 1 / (1 - p t): beyond p = 1.1 there is nothing in the window."""
        model = Model(
            name='pole',
            states=(Variable('x', lower=0.0, upper=2.0),),
            outputs=(Variable('y'),),
            parameters=(Variable('p', lower=0.0, upper=4.0),),
            dynamics=lambda t, x, u, p: (p[0] * x[0] * x[0],),
            output=lambda t, x, u, p: (x[0],),
            max_step=0.005,
        )
        t = np.linspace(0.0, 0.9, 19)
        y = 1.0 / (1.0 - t)
        objective = window_of(model, Record(t, None, y), 9.0, backend, fixed={'x': 1.0})
        ends = ends_of(
            Posterior(objective, Prior.box(objective.unknowns).knowledge), np.array([0.25])
        )

        def growth(p: float) -> float:
            return float((((1.0 / (1.0 - p * t)) - y) ** 2).sum() / 81.0) - LEVEL

        upper = brentq(growth, 1.0, 1.11)
        assert upper < 1.1
        assert growth(0.0) < 0.0  # hardly anything speaks against lower ones
        np.testing.assert_array_equal(ends.closed, [False, True])
        assert 4.0 * ends.points[1, 0] == pytest.approx(upper, abs=2e-3)
        assert ends.points[0, 0] == 0.0


def test_of_parameters_that_jump_it_is_the_value_at_the_end() -> None:
    """k jumps in mid-window. At an end no other point costs less, by scipy's simplex."""
    t, sigma = 0.2 * np.arange(61), 0.02
    u = np.ones(t.size)
    p = np.tile([1.5, 5.0], (t.size, 1))
    p[30:, 0] = 2.4
    y = lag_outputs(t, u, 0.0, p) + sigma * np.random.default_rng(3).standard_normal(t.size)
    objective = window_of(LAG, Record(t, u, y), sigma)
    rows = PiecewiseProblem(objective, Prior.box(objective.unknowns).knowledge, ((1,),))
    before = objective.unknowns.point({'x': 0.0, 'k': 1.5, 'tau': 5.0})
    z = optimum(rows, np.append(before, [0.5, (2.4 - 0.2) / 4.8]))
    pinned = rows.layout.final(z)[1:]
    assert pinned.tolist() == [4, 2]
    ends = profile_ends(rows, z, pinned, np.ones(2), LEVEL, PROBE, Deadline())
    assert ends.closed.all()
    least = float(rows.costs(z[None])[0])
    for point, k in zip(ends.points, ends.pinned, strict=True):

        def cost(others: Array, point: Array = point, k: int = k) -> float:
            whole = np.insert(others, k, point[k])
            inside = (whole > rows.limits[0]).all() and (whole < rows.limits[1]).all()
            return float(rows.costs(whole[None])[0]) if inside else np.inf

        found = minimize(cost, np.delete(point, k), method='Nelder-Mead', options={'maxiter': 200})
        assert found.fun - least == pytest.approx(LEVEL, abs=0.15)


def test_without_parameters_there_are_no_ends() -> None:
    posterior, z, _ = linear()
    nothing = np.zeros(0, dtype=np.int64)
    ends = profile_ends(posterior, z, nothing, np.zeros(0), LEVEL, PROBE, Deadline())
    assert ends.points.shape == (0, 4) and ends.closed.shape == ends.growth.shape == (0,)
    assert ends.better is None


def test_along_a_flat_valley_the_middle_stays_where_the_search_has_ended() -> None:
    """Of a + b alone something is known: no step along a - b gains anything."""
    posterior = rows_of(
        lambda z: [(z[:, 0] + z[:, 1] - 1.0) / 0.01, 1e-3 * (z[:, 0] - z[:, 1] - 5.0)]
    )
    z = np.array([0.7, 0.3])
    ends = ends_of(posterior, z)
    assert not ends.closed.any()
    np.testing.assert_allclose(ends.middle, z, atol=1e-3)


@pytest.mark.parametrize('seed', range(5))
def test_what_was_visited_costs_what_it_costs(seed: int) -> None:
    """Points on the way and beside the ends, where the cost is a parabola: all on or above it."""
    posterior, z, covariance = linear(seed)
    ends = ends_of(posterior, z)
    least = float(posterior.costs(z[None])[0])
    assert ends.visited.shape == (ends.costs.size, 4)
    assert ends.costs.size >= 8 + 8 * 8
    np.testing.assert_allclose(posterior.costs(ends.visited) - least, ends.costs, atol=0.02)
    np.testing.assert_allclose(enlarged(covariance, ends), covariance, rtol=0.02, atol=1e-7)
