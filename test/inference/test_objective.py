"""Tests of obs_ros.inference.objective."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from plants import BLOW_UP, NAN, OSCILLATOR

from obs_ros import Record
from obs_ros.core.typing import Array
from obs_ros.inference.objective import Latest, Objective
from obs_ros.inference.parameterisation import Unknowns
from obs_ros.integration.backends import kernels_for
from obs_ros.integration.grid import Grid, Injection

SCALE = np.array([0.5, 3.0])
T = np.linspace(0.0, 2.0, 31)


def window(missing: float = 0.3) -> Record:
    rng = np.random.default_rng(1)
    y = np.column_stack([np.cos(2.0 * T), -np.sin(2.0 * T)]) + 0.1 * rng.standard_normal((31, 2))
    y[rng.random((31, 2)) < missing] = NAN
    return Record(T, np.sin(T), y)


def objective(
    backend: Any, fitness: Any = 'least_squares', record: Record | None = None
) -> Objective:
    grid = Grid.of(OSCILLATOR, record or window(), SCALE)
    return Objective(kernels_for(OSCILLATOR, backend), grid, Unknowns.of(OSCILLATOR), fitness)


def candidates(count: int = 6) -> Array:
    return np.random.default_rng(2).uniform(0.1, 0.9, (count, 4))


def outputs(problem: Objective, z: Array) -> Array:
    """Outputs (K, r, B)."""
    return problem.kernels.trajectories(problem.grid, *problem.unknowns.values(z))[1]


def test_least_squares(backend: str) -> None:
    problem, z, y = objective(backend), candidates(), window().y
    for nodes in (None, 12):
        residual = ((outputs(problem, z) - y[..., None]) / SCALE[:, None])[:nodes]
        expected = np.nansum(residual**2, axis=(0, 1))
        np.testing.assert_allclose(problem.costs(z, nodes), expected, rtol=1e-11)


def test_euclidean_is_the_sum_of_the_outputs_norms(backend: str) -> None:
    """f_t1 of Yang et al. 2020, with its sign turned."""
    problem, z, y = objective(backend, 'euclidean'), candidates(), window().y
    residual = (outputs(problem, z) - y[..., None]) / SCALE[:, None]
    expected = np.sqrt(np.nansum(residual**2, axis=0)).sum(axis=0)
    np.testing.assert_allclose(problem.costs(z), expected, rtol=1e-11)


def test_correlation_is_pearsons(backend: str) -> None:
    """f_t2 of Yang et al. 2020, eq. 14, with its sign turned, and 0 at its best."""
    problem, z, y = objective(backend, 'correlation'), candidates(), window().y
    for nodes in (31, 15):
        expected = np.full(len(z), 2.0)
        for i in range(2):
            known = np.flatnonzero(np.isfinite(y[:nodes, i]))
            for b, candidate in enumerate(outputs(problem, z)[known, i].T):
                expected[b] -= np.corrcoef(candidate, y[known, i])[0, 1]
        np.testing.assert_allclose(problem.costs(z, nodes), expected, rtol=1e-10)


@pytest.mark.parametrize('fitness', ['least_squares', 'euclidean', 'correlation'])
def test_the_truth_costs_nothing_and_everything_else_more(backend: str, fitness: str) -> None:
    blank = objective(backend)
    truth = np.array([[0.7, 0.4, 0.5, 0.3]])
    y = outputs(blank, truth)[..., 0]
    problem = objective(backend, fitness, Record(T, np.sin(T), y))
    costs = problem.costs(np.vstack([truth, candidates()]))
    assert costs[0] == pytest.approx(0.0, abs=1e-12)
    assert costs[1:].min() > 1e-3


def test_block_squares_add_up_to_the_costs(backend: str) -> None:
    problem, z = objective(backend), candidates()
    prefixes = np.array([4, 5, 20, 31])
    blocks = problem.block_squares(z, prefixes)
    assert blocks.shape == (4, 6)
    np.testing.assert_allclose(np.cumsum(blocks, axis=0)[2], problem.costs(z, 20), rtol=1e-12)
    np.testing.assert_allclose(blocks.sum(axis=0), problem.costs(z), rtol=1e-12)


@pytest.mark.parametrize('nodes', [31, 14])
def test_linearise_against_central_differences(backend: str, nodes: int) -> None:
    problem, z = objective(backend), candidates()
    z[0] = (0.0, 1.0, 0.0, 1.0)  # at the box, where steps must go inward
    squares, gradient, hessian = problem.linearise(z, np.full(z.shape, 1e-7), nodes)
    np.testing.assert_allclose(squares, problem.costs(z, nodes), rtol=1e-11)
    known = np.isfinite(window().y[:nodes])

    def residual(point: Array) -> Array:
        scaled = (outputs(problem, point[None])[:nodes, :, 0] - window().y[:nodes]) / SCALE
        return np.asarray(scaled[known])

    for b, point in enumerate(z):
        steps = 1e-5 * np.eye(4)
        jacobian = np.array([(residual(point + s) - residual(point - s)) / 2e-5 for s in steps]).T
        size = np.abs(jacobian.T @ residual(point)).max()
        np.testing.assert_allclose(
            gradient[b], jacobian.T @ residual(point), rtol=1e-5, atol=1e-5 * size
        )
        np.testing.assert_allclose(hessian[b], jacobian.T @ jacobian, rtol=1e-5, atol=1e-5)


def test_linearise_stays_inside_the_box() -> None:
    problem = objective('numpy')
    unknowns, grams = problem.unknowns, problem.kernels.grams
    seen: list[Array] = []

    class Spy:
        def grams(self, grid: Grid, nodes: int, x0: Array, p: Array, width: int) -> Array:
            seen.append(np.concatenate([x0, p]))
            return grams(grid, nodes, x0, p, width)

    spied = replace(problem, kernels=Spy())  # type: ignore[arg-type]
    spied.linearise(np.array([[0.0, 1.0, 0.5, 1.0]]), np.full((1, 4), 1e-3), 31)
    assert seen[0].shape == (4, 5)
    assert (seen[0] >= unknowns.scale.lower[:, None]).all()
    assert (seen[0] <= unknowns.scale.upper[:, None]).all()


def test_residuals_are_nan_where_nothing_was_measured(backend: str) -> None:
    problem, z = objective(backend), candidates(1)
    residuals = problem.residuals(z[0])
    expected = (outputs(problem, z)[..., 0] - window().y) / SCALE
    np.testing.assert_allclose(residuals, expected, rtol=1e-11, equal_nan=True)
    states, again = problem.trajectory(z[0])
    np.testing.assert_array_equal(residuals, again)
    np.testing.assert_allclose(states[0], problem.unknowns.values(z)[0][:, 0], rtol=1e-15)


@pytest.mark.parametrize('fitness', ['least_squares', 'euclidean', 'correlation'])
def test_candidates_that_diverge_cost_infinity_and_harm_no_other(
    backend: str, fitness: Any
) -> None:
    t = np.linspace(0.0, 1.0, 21)
    record = Record(t, None, 1.0 / (3.0 - t))
    unknowns = Unknowns.of(BLOW_UP, bounds={'x': (0.1, 1e200)})
    problem = Objective(
        kernels_for(BLOW_UP, backend), Grid.of(BLOW_UP, record, np.ones(1)), unknowns, fitness
    )
    costs = problem.costs(np.array([[0.0], [1.0], [0.5], [0.0]]))
    assert costs[1:3].tolist() == [np.inf, np.inf]
    assert np.isfinite(costs[[0, 3]]).all()


def test_it_counts_candidates_values_and_signal() -> None:
    problem, y = objective('numpy'), window().y
    assert (problem.dimension, problem.nodes) == (4, 31)
    assert problem.count(31) == np.isfinite(y).sum()
    assert problem.count(10) == np.isfinite(y[:10]).sum()
    centred = (y - np.nanmean(y, axis=0)) / SCALE
    assert problem.signal == pytest.approx(np.nanmean(centred**2), rel=1e-12)
    assert problem.floor(31) == pytest.approx(1e-18 * np.nansum((y / SCALE) ** 2), rel=1e-12)
    assert problem.evaluations == 0
    problem.costs(candidates(6))
    assert problem.evaluations == 6
    problem.linearise(candidates(2), np.full((2, 4), 1e-7), 31)
    assert problem.evaluations == 6 + 2 * 5


def test_a_point_is_rolled_out_once_for_all_scales_and_anew_for_all_else(backend: str) -> None:
    """A rollout that is kept must be that of the same point, in the same steps and inputs."""
    problem, (z, other) = objective(backend), candidates(2)
    factors, grid = np.array([3.0, 0.25]), problem.grid
    states, residuals = problem.trajectory(z)
    again = problem.rescaled(factors).trajectory(z)
    assert problem.evaluations == 1
    np.testing.assert_array_equal(again[0], states)
    np.testing.assert_allclose(again[1], residuals / factors, rtol=1e-14)
    z[0] += 0.01  # whoever changes a point in place asks for another one
    injection = Injection(np.zeros((31, 2, 4)), np.zeros((31, 2, 2)), np.zeros(0, dtype=np.int64))
    others = [
        (problem, z),
        (problem, other),
        (replace(problem, grid=grid.stepped(2 * grid.steps)), z),
        (replace(problem, grid=grid.injected(injection, grid.weight**2)), z),
        (replace(problem, grid=grid.without(np.eye(31, 2, dtype=bool))), z),
        (replace(problem, unknowns=Unknowns.of(OSCILLATOR)), z),
    ]
    for number, (one, point) in enumerate(others, 1):
        fresh = replace(one, latest=Latest())
        np.testing.assert_array_equal(one.trajectory(point)[1], fresh.trajectory(point)[1])
        assert problem.evaluations == 1 + 2 * number


def test_an_unknown_fitness_is_refused() -> None:
    with pytest.raises(ValueError, match="fitness 'l1' is none of least_squares, euclidean"):
        objective('numpy', 'l1')


@pytest.mark.parametrize('blank', [NAN, 5.0])
def test_correlation_leaves_out_an_output_that_tells_nothing(backend: str, blank: float) -> None:
    y = window().y.copy()
    y[:, 1] = blank
    problem, z = objective(backend, 'correlation', Record(T, np.sin(T), y)), candidates()
    known = np.flatnonzero(np.isfinite(y[:, 0]))
    expected = [1.0 - np.corrcoef(c, y[known, 0])[0, 1] for c in outputs(problem, z)[known, 0].T]
    np.testing.assert_allclose(problem.costs(z), expected, rtol=1e-10)


def test_where_no_output_varies_nothing_correlates() -> None:
    y = np.full((31, 2), 5.0)
    problem = objective('numpy', 'correlation', Record(T, np.sin(T), y))
    assert problem.costs(candidates()).tolist() == [np.inf] * 6


def test_an_output_never_measured_adds_no_signal() -> None:
    y = window().y.copy()
    y[:, 1] = NAN
    problem = objective('numpy', record=Record(T, np.sin(T), y))
    assert problem.signal == pytest.approx(np.nanvar(y[:, 0]) / SCALE[0] ** 2, rel=1e-12)
