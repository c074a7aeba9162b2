"""Tests of obs_ros.inference.jumps.piecewise."""

from typing import Any

import numpy as np
import pytest
from plants import (
    INTEGRATOR,
    LAG,
    NAN,
    OSCILLATOR,
    integrator_design,
    lag_outputs,
    square_wave,
    window_of,
)

from obs_ros import Record
from obs_ros.core.typing import Array
from obs_ros.inference.jumps.piecewise import PiecewiseProblem, interval_of
from obs_ros.inference.prior import Prior

T = 2.0 + 0.1 * np.arange(101)
U = square_wave(T)
SIGMA = 0.1
K, TAU = 1, 2  # places in z, after x


def problem(
    *events: tuple[int, ...], backend: Any = 'numpy', y: Any = None, **settings: Any
) -> PiecewiseProblem:
    record = Record(T, U, np.sin(T) if y is None else y)
    objective = window_of(LAG, record, SIGMA, backend, **settings)
    return PiecewiseProblem(objective, Prior.box(objective.unknowns), events)


def share(seconds: float) -> float:
    """A time as a share of the window."""
    return (seconds - 2.0) / 10.0


def boxes(k: float | None = None, tau: float | None = None) -> list[float]:
    """Values in boxes."""
    found = [] if k is None else [(k - 0.2) / 4.8]
    return found if tau is None else [*found, (tau - 1.0) / 19.0]


def test_the_interval_of_a_time() -> None:
    t = np.array([0.0, 1.0, 3.0])
    times = np.array([-1.0, 0.0, 1e-9, 1.0, 1.0 + 1e-9, 3.0, 9.0])
    assert interval_of(t, times).tolist() == [0, 0, 0, 0, 1, 1, 1]


class TestRoll:
    """Against the lag in closed form from node to node."""

    def piecewise(self, *pieces: tuple[float, float, float]) -> Array:
        """k and tau from each node to the next of (from s, k, tau), means where both hold."""
        found = np.zeros((100, 2))
        edges = [*[piece[0] for piece in pieces], np.inf]
        for first, last, (_, *values) in zip(edges, edges[1:], pieces):
            held = np.clip(np.minimum(T[1:], last) - np.maximum(T[:-1], first), 0.0, None)
            found += np.outer(held / np.diff(T), values)
        return found

    def test_without_a_jump_it_is_the_model(self, backend: str) -> None:
        point = np.array([0.55, *boxes(2.0, 4.0)])
        _, y = problem(backend=backend).roll(point[None])
        expected = lag_outputs(T, U, 1.0, self.piecewise((0.0, 2.0, 4.0)))
        np.testing.assert_allclose(y[:, 0, 0], expected, atol=1e-8)

    @pytest.mark.parametrize('moment', [2.03, 2.1, 6.24, 6.3, 6.37, 11.9, 11.99])
    def test_one_jump(self, backend: str, moment: float) -> None:
        point = np.array([0.55, *boxes(2.0, 4.0), share(moment), *boxes(tau=9.0)])
        states, y = problem((TAU,), backend=backend).roll(point[None])
        expected = lag_outputs(T, U, 1.0, self.piecewise((0.0, 2.0, 4.0), (moment, 2.0, 9.0)))
        np.testing.assert_allclose(y[:, 0, 0], expected, atol=1e-8)
        np.testing.assert_array_equal(states, y)

    def test_two_parameters_at_once(self, backend: str) -> None:
        point = np.array([0.55, *boxes(2.0, 4.0), share(5.55), *boxes(3.0, 9.0)])
        _, y = problem((K, TAU), backend=backend).roll(point[None])
        expected = lag_outputs(T, U, 1.0, self.piecewise((0.0, 2.0, 4.0), (5.55, 3.0, 9.0)))
        np.testing.assert_allclose(y[:, 0, 0], expected, atol=1e-8)

    @pytest.mark.parametrize(('first', 'second'), [(4.44, 8.18), (8.18, 4.44), (6.02, 6.07)])
    def test_two_events(self, backend: str, first: float, second: float) -> None:
        point = np.array(
            [0.55, *boxes(2.0, 4.0), share(first), *boxes(k=3.0), share(second), *boxes(tau=9.0)]
        )
        _, y = problem((K,), (TAU,), backend=backend).roll(point[None])
        middle = (3.0, 4.0) if first < second else (2.0, 9.0)
        pieces = ((0.0, 2.0, 4.0), (min(first, second), *middle), (max(first, second), 3.0, 9.0))
        expected = lag_outputs(T, U, 1.0, self.piecewise(*pieces))
        np.testing.assert_allclose(y[:, 0, 0], expected, atol=1e-8)

    def test_one_parameter_twice(self) -> None:
        for first, second in ((5.12, 9.9), (5.12, 5.17)):
            point = np.array(
                [0.55, *boxes(2.0, 4.0), share(first), *boxes(k=3.0), share(second), *boxes(k=1.0)]
            )
            _, y = problem((K,), (K,)).roll(point[None])
            pieces = ((0.0, 2.0, 4.0), (first, 3.0, 4.0), (second, 1.0, 4.0))
            expected = lag_outputs(T, U, 1.0, self.piecewise(*pieces))
            np.testing.assert_allclose(y[:, 0, 0], expected, atol=1e-8)

    def test_beside_fixed_values(self, backend: str) -> None:
        only = problem((0,), backend=backend, fixed={'x': 1.0, 'k': 2.0})
        point = np.array([*boxes(tau=4.0), share(6.24), *boxes(tau=9.0)])
        _, y = only.roll(point[None])
        expected = lag_outputs(T, U, 1.0, self.piecewise((0.0, 2.0, 4.0), (6.24, 2.0, 9.0)))
        np.testing.assert_allclose(y[:, 0, 0], expected, atol=1e-8)

    def test_many_points_are_as_each_alone(self, backend: str) -> None:
        points = np.random.default_rng(1).uniform(0.2, 0.8, (5, 5))
        points[:, 3] = 0.4232 + 0.001 * np.arange(5)  # all between the same two nodes
        rolled = problem((TAU,), backend=backend)
        states, y = rolled.roll(points)
        for i, point in enumerate(points):
            alone = rolled.roll(point[None])
            np.testing.assert_allclose(states[..., i], alone[0][..., 0], rtol=1e-12)
            np.testing.assert_allclose(y[..., i], alone[1][..., 0], rtol=1e-12)
        assert rolled.objective.evaluations == 10

    def test_it_is_continuous_in_the_time(self) -> None:
        rolled = problem((TAU,))
        for node in (0.0, 0.5, 1.0):
            ys = []
            for off in (-1e-9, 1e-9):
                point = np.array([0.55, *boxes(2.0, 4.0), np.clip(node + off, 0.0, 1.0), 0.9])
                ys.append(rolled.roll(point[None])[1])
            np.testing.assert_allclose(*ys, atol=1e-7)  # 2e-8 s apart

    def test_of_a_plant_linear_in_its_parameters_it_is_exact(self) -> None:
        objective = window_of(INTEGRATOR, Record(T, U, U), SIGMA)
        rolled = PiecewiseProblem(objective, Prior.box(objective.unknowns), ((2,),))
        point = np.array([0.5, 0.75, 0.4, share(6.283), 0.9])  # drift from -0.2 to 0.8
        y = rolled.roll(point[None])[1][:, 0, 0]
        expected = integrator_design(T, U) @ [0.0, 1.5, -0.2] + np.maximum(T - 6.283, 0.0)
        np.testing.assert_allclose(y, expected, atol=1e-12)


POINT = np.array([0.55, 0.4, 0.3, 0.4237, 0.6, 0.7, 0.8119, 0.2])
EVENTS = ((K, TAU), (K,))


def test_jacobians_against_central_differences(backend: str) -> None:
    y = np.sin(T)
    y[::3] = NAN
    y[-4:] = NAN
    rolled = problem(*EVENTS, backend=backend, y=y)
    linearisation = rolled.linearisation(POINT, np.full(8, 1e-7))
    assert linearisation.residual.shape == (np.isfinite(y).sum(),)
    for i in range(8):
        ends, rows = [], []
        for step in (-1e-5, 1e-5):
            moved = POINT.copy()
            moved[i] += step
            states, outputs = rolled.roll(moved[None])
            ends.append(states[95, :, 0])  # the last one measured
            rows.append(outputs[np.isfinite(y), 0, 0] / SIGMA)
        slope = (rows[1] - rows[0]) / 2e-5
        np.testing.assert_allclose(
            linearisation.jacobian[:, i], slope, atol=1e-4 * np.abs(slope).max()
        )
        slope = (ends[1] - ends[0]) / 2e-5
        np.testing.assert_allclose(linearisation.state_jacobian[:, i], slope, rtol=1e-4, atol=1e-4)


@pytest.mark.parametrize('time', [0.0, 0.42, 0.425, 0.43, 1.0])
def test_differences_in_time_stay_in_the_interval(time: float) -> None:
    """At a node the slope is that of the interval before, which is the one that holds it."""
    rolled = problem((TAU,))
    point = np.array([0.55, 0.4, 0.3, time, 0.9])
    slope = rolled.linearisation(point, np.full(5, 1e-7)).jacobian[:, 3]
    towards = 1e-5 if time == 0.0 else -1e-5
    moved = point.copy()
    moved[3] += towards
    y = rolled.roll(np.array([moved]))[1] - rolled.roll(np.array([point]))[1]
    expected = y[:, 0, 0] / SIGMA / towards
    np.testing.assert_allclose(slope, expected, atol=1e-2 * max(1.0, np.abs(expected).max()))


def test_squares_are_those_of_residuals_prior_and_sizes() -> None:
    rolled = problem(*EVENTS)
    residual = (rolled.roll(POINT[None])[1][:, 0, 0] - np.sin(T)) / SIGMA
    prior = 0.01 * 0.05**2 + 12.0 * (0.1**2 + 0.2**2)
    # k by 0.2 and tau by 0.4, then k from there by -0.4.
    sizes = 12.0 * (0.2**2 + 0.4**2 + 0.4**2)
    squares, gradient, hessian = rolled.linearise(POINT[None], np.full((1, 8), 1e-7), 101)
    assert squares[0] == pytest.approx(residual @ residual + prior + sizes, rel=1e-10)
    for i in range(8):
        around = []
        for step in (-1e-5, 1e-5):
            moved = POINT.copy()
            moved[i] += step
            around.append(rolled.linearise(moved[None], np.full((1, 8), 1e-7), 101)[0][0])
        slope = (around[1] - around[0]) / 2e-5
        assert 2.0 * gradient[0, i] == pytest.approx(slope, rel=1e-4, abs=0.1)
    np.testing.assert_allclose(hessian[0], hessian[0].T)
    only = rolled.linearisation(POINT, np.full(8, 1e-7)).jacobian
    added = hessian[0] - only.T @ only
    assert added[1, 1] == pytest.approx(24.0)  # its prior, and the jump from it
    assert added[4, 4] == pytest.approx(24.0)  # the jumps to and from it
    assert (added[7, 7], added[1, 4], added[4, 7]) == pytest.approx((12.0, -12.0, -12.0))
    assert np.abs(added[[3, 6]]).max() < 1e-6 * np.abs(hessian).max()  # times


def test_the_size_of_a_jump_is_free_where_there_is_no_bound() -> None:
    free = problem((K,), bounds={'k': (0.2, np.inf)})
    assert free.precision(np.array([0.5, 0.4, 0.3, 0.5, 0.6]))[4, 4] == pytest.approx(0.01)
    np.testing.assert_array_equal(free.limits, [[0, 0, 0, 0, 0], [1, np.inf, 1, 1, np.inf]])


def test_walls_of_times_and_values() -> None:
    np.testing.assert_array_equal(problem(*EVENTS).limits, [np.zeros(8), np.ones(8)])


def test_the_trajectory_has_gaps_where_nothing_was_measured() -> None:
    t = np.linspace(0.0, 2.0, 31)
    y = np.column_stack([np.cos(t), np.sin(t)])
    y[3, 0] = NAN
    y[7:9] = NAN
    objective = window_of(OSCILLATOR, Record(t, np.sin(t), y), 0.5)
    rolled = PiecewiseProblem(objective, Prior.box(objective.unknowns), ((2,),))
    point = np.array([0.6, 0.4, 0.5, 0.5, 0.3, 0.9])
    states, residuals = rolled.trajectory(point)
    assert states.shape == (31, 2)
    np.testing.assert_array_equal(np.isnan(residuals), np.isnan(y))
    outputs = rolled.roll(point[None])[1][..., 0]
    np.testing.assert_allclose(residuals, (outputs - y) / 0.5)
    assert rolled.rows(point[None]).shape == (57, 1)
    linearisation = rolled.linearisation(point, np.full(6, 1e-7))
    np.testing.assert_allclose(linearisation.residual, residuals[np.isfinite(y)], rtol=1e-12)
    np.testing.assert_array_equal(linearisation.state, states[-1])


def test_steps_of_a_time_are_not_rounded_away_in_seconds_since_1970() -> None:
    """There a float resolves 2.4e-7 s; a step of 1e-8 of 10 s is shorter."""
    late = Record(T + 1.7e9, U, np.sin(T))
    point = np.array([0.55, 0.4, 0.3, 0.4237, 0.9])
    jacobians = []
    for record in (Record(T, U, np.sin(T)), late):
        objective = window_of(LAG, record, SIGMA)
        rolled = PiecewiseProblem(objective, Prior.box(objective.unknowns), ((TAU,),))
        jacobians.append(rolled.linearisation(point, np.full(5, 1e-8)).jacobian)
    # The nodes themselves are rounded, by 2.4e-6 of their distance.
    np.testing.assert_allclose(*jacobians, rtol=1e-3, atol=1e-2)
