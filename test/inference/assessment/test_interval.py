"""Tests of obs_ros.inference.assessment.interval."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from plants import LAG, lag_outputs, square_wave, window_of
from scipy.optimize import brentq, least_squares

from obs_ros import Model, Record, Variable
from obs_ros.core.deadline import Deadline
from obs_ros.core.typing import Array
from obs_ros.inference.assessment.interval import (
    Determined,
    Interval,
    covariance_without_boxes,
    determined,
    enlarged,
    other_starts,
)
from obs_ros.inference.assessment.profile import Ends
from obs_ros.inference.jumps.hypothesis import Hypothesis, hypothesis_at
from obs_ros.inference.jumps.piecewise import PiecewiseProblem
from obs_ros.inference.prior import Prior
from obs_ros.optimization.levenberg_marquardt import levenberg_marquardt

T = 0.2 * np.arange(41)
SIGMA = 0.05
K, TAU = 1.5, 9.0


def fitted(
    model: Model, record: Record, sigma: float, start: Mapping[str, float], **settings: Any
) -> Hypothesis:
    """The optimum with the boxes as a prior, as the search finds it."""
    objective = window_of(model, record, sigma, **settings)
    problem = PiecewiseProblem(objective, Prior.box(objective.unknowns))
    z = objective.unknowns.point(start)
    found = levenberg_marquardt(problem, z[None], record.t.size, 100, Deadline())
    return hypothesis_at(problem, found.z[0])


def step_response(sigma: float, tau: float = TAU) -> Record:
    y = lag_outputs(T, np.ones(T.size), 0.0, np.tile([K, tau], (T.size, 1)))
    noise = sigma * np.random.default_rng(4).standard_normal(T.size)
    return Record(T, np.ones(T.size), y + noise)


def lag(sigma: float = SIGMA, tau: float = TAU, **settings: Any) -> Hypothesis:
    """A step response that is cut off: of k and tau hardly more than the ratio is told."""
    start = {'x': 0.0, 'k': K, 'tau': tau}
    return fitted(LAG, step_response(sigma, tau), sigma, start, **settings)


def rich(backend: Any = 'numpy') -> Hypothesis:
    t = 0.1 * np.arange(301)
    u = square_wave(t)
    y = lag_outputs(t, u, 0.0, np.tile([K, TAU], (t.size, 1)))
    record = Record(t, u, y + 0.01 * np.random.default_rng(1).standard_normal(t.size))
    return fitted(LAG, record, 0.01, {'x': 0.0, 'k': K, 'tau': TAU}, backend=backend)


def least_squares_of_lag(sigma: float, tau: float = TAU) -> tuple[Array, Any]:
    """x(0), k and tau in their units by scipy without boxes, and its function of residuals."""
    record = step_response(sigma, tau)

    def residuals(values: Array) -> Array:
        p = np.tile(values[1:], (T.size, 1))
        return (lag_outputs(T, record.u[:, 0], values[0], p) - record.y[:, 0]) / sigma

    found = least_squares(residuals, [0.0, K, tau], xtol=1e-12, ftol=1e-12, x_scale=[1.0, 1.0, 5.0])
    return found.x, residuals


def in_units(best: Hypothesis, z: Array) -> Array:
    """Parameters (2,) in boxes in their units."""
    states = best.problem.objective.unknowns.n_states
    point = np.append(np.full(states, 0.5), z)
    return np.asarray(best.problem.objective.unknowns.scale.values(point))[states:]


class TestPoint:
    def test_boxes_bound_but_do_not_pull(self, backend: str) -> None:
        """By squares, of which a search leaves a few hundredths."""
        sigma, tau = 0.3, 5.0
        best = lag(sigma, tau=tau, backend=backend)
        optimum, residuals = least_squares_of_lag(sigma, tau)
        least = float((residuals(optimum) ** 2).sum())
        scale = best.problem.objective.unknowns.scale
        assert scale.values(best.point)[2] - optimum[2] > 3.0  # towards the middle of the box
        assert best.squares - least > 0.15
        found = determined(best, 1.0, Deadline()).hypothesis
        assert found.squares - least < 0.05
        assert abs(scale.values(found.point)[2] - optimum[2]) < 1.5
        # The boxes still steady later searches.
        assert found.problem.prior is best.problem.prior

    def test_a_point_that_is_not_movable_stays(self) -> None:
        best = lag()
        found = determined(best, 1.0, Deadline(), movable=False)
        assert found.hypothesis is best

    def test_rich_windows_keep_their_bits(self, backend: str) -> None:
        best = rich(backend)
        found = determined(best, 1.0, Deadline())
        assert found.hypothesis is best and found.interval is None
        jacobian = best.linearisation.jacobian
        weak = np.diag([0.01, 0.01, 0.01])
        expected = np.linalg.inv(jacobian.T @ jacobian + weak)
        np.testing.assert_allclose(found.covariance, expected, rtol=1e-9)

    def test_they_pay_one_rollout(self) -> None:
        best = rich()
        before = best.problem.objective.evaluations
        determined(best, 1.0, Deadline())
        assert best.problem.objective.evaluations - before <= 1 + 2 * 3

    def test_a_better_optimum_on_a_profile_is_published(self) -> None:
        """a^2 is known, and a little of a: the search has ended where the sign is wrong."""
        model = Model(
            name='two_valleys',
            states=(Variable('x', lower=-9.0, upper=9.0),),
            outputs=(Variable('square'), Variable('sign')),
            parameters=(Variable('a', lower=-1.5, upper=1.5),),
            dynamics=lambda t, x, u, p: (0.0 * x[0],),
            output=lambda t, x, u, p: (p[0] * p[0], 0.3 * p[0]),
        )
        t = np.arange(11.0)
        record = Record(t, None, np.tile([0.64, 0.24], (t.size, 1)))
        best = fitted(model, record, 1.0, {'x': 0.0, 'a': -0.7}, fixed={'x': 0.0})
        scale = best.problem.objective.unknowns.scale
        assert scale.values(best.point)[0] < -0.5
        stays = determined(best, 1.0, Deadline(), movable=False)
        assert stays.hypothesis is best
        found = determined(best, 1.0, Deadline())
        assert scale.values(found.hypothesis.point)[0] == pytest.approx(0.8, abs=1e-3)
        assert found.hypothesis.squares < best.squares - 0.5


class TestIntervals:
    def test_ends_are_those_of_the_profile_by_scipy(self, backend: str) -> None:
        sigma = 0.03
        best = lag(sigma, backend=backend)
        optimum, residuals = least_squares_of_lag(sigma)
        least = float((residuals(optimum) ** 2).sum())
        found = determined(best, 1.0, Deadline()).interval
        assert found is not None

        def growth(value: float, i: int) -> float:
            def part(w: Array) -> Array:
                return np.asarray(residuals(np.insert(w, i, value)))

            other = least_squares(part, np.delete(optimum, i), x_scale=[1.0, 2.0], xtol=1e-12)
            return 2.0 * float(other.cost) - least - 3.84

        for i, low, high in ((1, 0.8, 3.0), (2, 5.0, 19.0)):
            expected = [
                brentq(growth, low, optimum[i], args=(i,), xtol=1e-4),
                brentq(growth, optimum[i], high, args=(i,), xtol=1e-4),
            ]
            ends = [in_units(best, side)[i - 1] for side in (found.lower, found.upper)]
            np.testing.assert_allclose(ends, expected, rtol=0.01)
            assert in_units(best, found.middle)[i - 1] == pytest.approx(optimum[i], rel=2e-3)

    def test_inflation_of_the_variances_counts_for_the_growth(self) -> None:
        """Four times the variance is twice the noise."""
        inflated = determined(lag(0.02), 4.0, Deadline()).interval
        record = step_response(0.02)
        noisy = fitted(LAG, record, 0.04, {'x': 0.0, 'k': K, 'tau': TAU})
        plain = determined(noisy, 1.0, Deadline()).interval
        assert inflated is not None and plain is not None
        np.testing.assert_allclose(inflated.lower, plain.lower, atol=2e-3)
        np.testing.assert_allclose(inflated.upper, plain.upper, atol=2e-3)

    def test_states_at_the_end_are_those_on_the_profiles(self) -> None:
        found = determined(lag(0.03), 1.0, Deadline())
        assert found.interval is not None
        low, high = found.interval.states
        state = found.hypothesis.linearisation.state
        assert (low <= state + 1e-9).all() and (high >= state - 1e-9).all()
        assert high[0] - low[0] < 0.06  # the output is measured there

    def test_without_time_nothing_is_told(self) -> None:
        found = determined(lag(), 1.0, Deadline(0.0))
        assert found.interval is None or np.isnan(found.interval.lower).all()

    def test_without_parameters_the_parabola_is_all(self) -> None:
        fixed = {'k': K, 'tau': TAU}
        best = fitted(LAG, step_response(SIGMA), SIGMA, {'x': 0.0}, parameters=[], fixed=fixed)
        found = determined(best, 1.0, Deadline())
        assert found.interval is None and found.covariance.shape == (1, 1)
        weight = np.exp(-T / TAU) * 20.0 / SIGMA
        assert found.covariance[0, 0] == pytest.approx(1.0 / (weight @ weight + 0.01), rel=1e-3)

    def test_widened(self) -> None:
        interval = Interval(
            np.array([0.2, np.nan]), np.array([0.3, 0.5]), np.array([0.5, 0.9]), np.zeros((2, 1))
        )
        found = interval.widened(np.array([2.0, 3.0]))
        np.testing.assert_allclose(found.lower, [0.1, np.nan])
        np.testing.assert_allclose(found.upper, [0.7, 1.7])
        np.testing.assert_array_equal(found.middle, interval.middle)
        np.testing.assert_array_equal(found.states, interval.states)


# x' = -c v: of a friction so small that it may be none at all.
FRICTION = Model(
    name='friction',
    states=(Variable('v', lower=0.0, upper=4.0),),
    outputs=(Variable('y'),),
    parameters=(Variable('c', lower=0.0, upper=1.0),),
    dynamics=lambda t, x, u, p: (-p[0] * x[0],),
    output=lambda t, x, u, p: (x[0],),
    max_step=0.1,
)


def friction(physical: Any, truth: float = 0.002, **settings: Any) -> Determined:
    parameter = replace(FRICTION.parameters[0], physical=physical)
    model = replace(FRICTION, parameters=(parameter,))
    noise = 0.1 * np.random.default_rng(2).standard_normal(T.size)
    record = Record(T, None, 2.0 * np.exp(-truth * T) + noise)
    best = fitted(model, record, 0.1, {'v': 2.0, 'c': 0.05}, **settings)
    return determined(best, 1.0, Deadline())


class TestBounds:
    @pytest.mark.parametrize('physical', ['lower', 'both'])
    def test_at_a_physical_bound_an_interval_ends(self, physical: Any) -> None:
        found = friction(physical)
        assert found.interval is not None
        assert found.interval.lower[0] == 0.0
        assert 0.0 < found.interval.upper[0] < 0.05

    @pytest.mark.parametrize('physical', ['none', 'upper'])
    def test_another_bound_is_a_guess(self, physical: Any) -> None:
        found = friction(physical)
        assert found.interval is not None
        assert np.isnan(found.interval.lower[0])
        assert 0.0 < found.interval.upper[0] < 0.05

    def test_so_are_bounds_that_the_user_gives_in_place_of_the_models(self) -> None:
        found = friction('lower', 0.101, bounds={'c': (0.1, 1.0)})
        assert found.interval is not None
        assert np.isnan(found.interval.lower[0])
        same = friction('lower', bounds={'c': (0.0, 0.5)})
        assert same.interval is not None
        assert same.interval.lower[0] == 0.0  # only the upper one is another

    def test_on_a_log_scale_the_profile_is_the_same(self) -> None:
        """A profile does not see in which units an unknown is searched: here it is a parabola."""
        log = replace(FRICTION.parameters[0], lower=1e-3, scale='log')
        noise = 0.1 * np.random.default_rng(2).standard_normal(T.size)
        record = Record(T, None, 2.0 * np.exp(-0.03 * T) + noise)
        found, linear = (
            determined(fitted(model, record, 0.1, {'v': 2.0, 'c': 0.03}), 1.0, Deadline())
            for model in (replace(FRICTION, parameters=(log,)), FRICTION)
        )
        assert found.interval is not None and linear.interval is None
        lower, upper = (in_units(found.hypothesis, side)[0]
                        for side in (found.interval.lower, found.interval.upper))  # fmt: skip
        c = in_units(linear.hypothesis, linear.hypothesis.point[1:])[0]
        half = 1.96 * np.sqrt(linear.covariance[1, 1])
        np.testing.assert_allclose([lower, upper], [c - half, c + half], atol=0.1 * half)
        # In ratios the lower half is the longer one.
        assert np.log(c / lower) > 1.2 * np.log(upper / c)


class TestOtherStarts:
    THIRDS = (1.0 / 6.0, 0.5, 5.0 / 6.0)

    @pytest.mark.parametrize('parameters', [1, 3, 8])
    def test_few_parameters_are_moved_one_at_a_time(self, parameters: int) -> None:
        z = 0.2 + 0.01 * np.arange(2 + parameters)
        starts = other_starts(z, states=2)
        assert len(starts) == 3 * parameters
        for k in range(parameters):
            moved = starts[3 * k : 3 * k + 3]
            np.testing.assert_allclose(moved[:, 2 + k], self.THIRDS)
            np.testing.assert_array_equal(np.delete(moved, 2 + k, 1) - np.delete(z, 2 + k), 0.0)

    def test_many_are_moved_in_groups_and_stand_in_each_part_once(self) -> None:
        z = np.linspace(0.2, 0.3, 5 + 30)
        starts = other_starts(z, states=5)
        assert len(starts) == 24
        assert (starts[:, :5] == z[:5]).all()
        moved = starts != z
        assert moved.sum(axis=0)[5:].tolist() == [3] * 30
        assert set(moved.sum(axis=1).tolist()) == {3, 4}
        for k in range(5, 35):
            np.testing.assert_allclose(np.sort(starts[moved[:, k], k]), self.THIRDS)
        for start, off in zip(starts, moved, strict=True):
            assert len({*start[off][:3]}) == 3


class TestEnlarged:
    @staticmethod
    def ends(points: Array, growth: Array) -> Ends:
        lanes = len(points)
        pinned = np.tile(np.arange(lanes // 2), 2)
        closed = np.ones(lanes, dtype=np.bool_)
        return Ends(pinned, np.full(2, 0.5), points, growth, closed, points, growth)

    def test_where_the_parabola_holds_nothing_changes(self) -> None:
        covariance = np.array([[4e-3, 1e-3], [1e-3, 2e-3]])
        off = np.sqrt(3.84) * covariance / np.sqrt(np.diagonal(covariance))[:, None]
        points = 0.5 + np.vstack([-off, off])
        found = enlarged(covariance, self.ends(points, np.full(4, 3.84 * (1.0 + 1e-9))))
        np.testing.assert_allclose(found, covariance, rtol=1e-9)

    def test_no_end_lies_further_than_the_cost_says(self) -> None:
        """Random ends, seeds 0 to 29; and the covariance never shrinks."""
        for seed in range(30):
            rng = np.random.default_rng(seed)
            root = 0.05 * rng.standard_normal((2, 2))
            covariance = root @ root.T + 1e-4 * np.eye(2)
            points = 0.5 + 0.3 * rng.standard_normal((4, 2))
            growth = rng.uniform(0.0, 4.0, 4)
            found = enlarged(covariance, self.ends(points, growth))
            off = points - 0.5
            distance = (off @ np.linalg.inv(found) * off).sum(axis=1)
            assert (distance <= np.maximum(growth, 1.0) * (1.0 + 1e-9)).all()
            assert np.linalg.eigvalsh(found - covariance)[0] >= -1e-12

    def test_one_end_grows_its_own_direction_alone(self) -> None:
        covariance = np.diag([1e-2, 1e-2])
        points = np.full((2, 2), 0.5)
        points[1, 0] = 1.3
        found = enlarged(covariance, self.ends(points, np.array([3.84, 3.84])))
        np.testing.assert_allclose(found, np.diag([0.64 / 3.84, 1e-2]), rtol=1e-9)

    def test_what_is_handed_on_allows_for_the_ends(self) -> None:
        best = lag()
        found = determined(best, 1.0, Deadline())
        assert found.interval is not None
        parabola = covariance_without_boxes(found.hypothesis)
        assert (np.diagonal(found.covariance) >= np.diagonal(parabola) * (1.0 - 1e-9)).all()
        told = np.isfinite(found.interval.upper)
        half = (found.interval.upper - found.interval.middle)[told]
        assert (half <= 1.97 * np.sqrt(np.diagonal(found.covariance)[1:][told])).all()


class TestJumps:
    def jumped(self, sigma: float, span: float) -> Hypothesis:
        """A step response of whose lag k jumps from 1.5 to 2.4 in mid-window."""
        t = np.linspace(0.0, span, 61)
        p = np.tile([K, 5.0], (t.size, 1))
        p[30:, 0] = 2.4
        y = lag_outputs(t, np.ones(t.size), 0.0, p)
        y += sigma * np.random.default_rng(3).standard_normal(t.size)
        objective = window_of(LAG, Record(t, np.ones(t.size), y), sigma)
        problem = PiecewiseProblem(objective, Prior.box(objective.unknowns), ((1,),))
        before = objective.unknowns.point({'x': 0.0, 'k': K, 'tau': 5.0})
        start = np.append(before, [0.5, (2.4 - 0.2) / 4.8])
        found = levenberg_marquardt(problem, start[None], t.size, 100, Deadline())
        return hypothesis_at(problem, found.z[0])

    def test_a_well_fed_window_has_no_profiles(self) -> None:
        best = self.jumped(0.003, 40.0)
        found = determined(best, 1.0, Deadline())
        assert found.hypothesis is best and found.interval is None
        np.testing.assert_array_equal(found.covariance, covariance_without_boxes(best))

    def test_intervals_are_those_after_the_jump_and_the_point_stays(self) -> None:
        best = self.jumped(0.04, 10.0)
        found = determined(best, 1.0, Deadline())
        assert found.hypothesis is best and found.interval is not None
        lower, upper = found.interval.lower[0], found.interval.upper[0]
        assert lower < best.point[4] < upper
        assert lower < (2.4 - 0.2) / 4.8 < upper
        assert not lower < best.point[1] < upper  # that is the one before
        assert upper - best.point[4] > 1.3 * (best.point[4] - lower)
