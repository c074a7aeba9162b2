"""Tests of obs_ros.integration.filter_pass: against a dense Kalman filter, and across backends."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from arx import ARX, B, F, course, kalman_filter, pushes
from arx import A as WEIGHTS
from kalman_reference import CART, NOISE, PRIOR, WALKS, X0, P, cart_window, dense_filter
from plants import BLOW_UP, NAN
from scipy.linalg import expm

from obs_ros import Record, Variable
from obs_ros.integration.backends import correction_rehearsed, kernels_for
from obs_ros.integration.filter_pass import Differences, FilterPass, central
from obs_ros.integration.grid import Grid
from obs_ros.integration.linear_path import LinearPath


def cart_pass(backend: str, **changes: Any) -> FilterPass:
    grid = Grid.of(CART, cart_window(), np.ones(3))
    arguments = {'walks': WALKS, 'noise': NOISE, 'P0': PRIOR, **changes}
    return kernels_for(CART, backend).filter(grid, X0, P, **arguments)


def test_the_pass_is_the_kalman_filter_of_a_linear_plant(backend: str) -> None:
    found, dense = cart_pass(backend), dense_filter(cart_window())
    assert found.moving.tolist() == [1]
    np.testing.assert_allclose(found.means, dense.means, rtol=1e-8, atol=1e-8)
    np.testing.assert_allclose(found.covariances, dense.covariances, rtol=1e-6, atol=1e-9)
    assert found.neg2_log_likelihood == pytest.approx(dense.neg2_log_likelihood, rel=1e-8)
    for k, S in enumerate(dense.S):
        seen = found.measured[k]
        mix = np.eye(3)[np.ix_(seen, seen)] + found.cross[k][np.ix_(seen, seen)]
        np.testing.assert_allclose(mix * found.S[k, seen] @ mix.T, S, rtol=1e-7, atol=1e-10)


def test_shapes_and_what_was_not_measured(backend: str) -> None:
    found = cart_pass(backend)
    assert found.states.shape == (61, 2) and found.parameters.shape == (61, 2)
    np.testing.assert_array_equal(found.parameters[:, 0], P[0])
    np.testing.assert_array_equal(found.parameters[:, 1], found.means[:, 2])
    assert found.P.shape == (4, 4)
    np.testing.assert_array_equal(found.P[np.ix_([0, 1, 3], [0, 1, 3])], found.covariances[-1])
    assert not found.P[2].any() and not found.P[:, 2].any()
    missing = ~np.isfinite(cart_window().y)
    assert np.isnan(found.S[missing]).all() and np.isnan(found.innovations[missing]).all()
    assert not found.gain[missing].any() and not found.gain[:, :, 2].any()
    assert not found.cross[missing].any() and not np.triu(found.cross).any()


def test_simpsons_rule_has_an_error_of_second_order_in_the_interval(backend: str) -> None:
    spring = replace(CART, dynamics=lambda t, x, u, p: (x[1], p[1] - 2.0 * x[0] - 0.3 * x[1]))
    exact = expm(0.4 * np.block([
        [-np.array([[0.0, 1.0], [-2.0, -0.3]]), np.diag(WALKS[:2] ** 2)],
        [np.zeros((2, 2)), np.array([[0.0, 1.0], [-2.0, -0.3]]).T],
    ]))  # fmt: skip
    errors = []
    for count in (4, 8, 16):
        t = np.linspace(0.0, 0.4, count + 1)
        y = np.full((t.size, 3), NAN)
        y[0] = 0.0
        grid = Grid.of(spring, Record(t, np.zeros((t.size, 1)), y), np.ones(3))
        found = kernels_for(spring, backend).filter(grid, X0, P, WALKS, NOISE)
        errors.append(np.abs(found.P[:2, :2] - exact[2:, 2:].T @ exact[:2, 2:]).max())
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.1)
    assert errors[1] / errors[2] == pytest.approx(4.0, rel=0.1)


def test_without_walks_the_pass_is_the_plain_rollout(backend: str) -> None:
    kernels, grid = kernels_for(CART, backend), Grid.of(CART, cart_window(), np.ones(3))
    found = kernels.filter(grid, X0, P, np.zeros(4), NOISE, moving=np.array([1]))
    states, outputs = kernels.trajectories(grid, X0[:, None], P[:, None])
    assert not found.gain.any() and not found.P.any()
    np.testing.assert_allclose(found.states, states[:, :, 0], rtol=1e-12, atol=1e-14)
    e = cart_window().y - outputs[:, :, 0]
    np.testing.assert_allclose(found.innovations, e, rtol=1e-12, atol=1e-13)
    expected = np.nansum(2.0 * np.log(NOISE) + (e / NOISE) ** 2, where=np.isfinite(e))
    assert found.neg2_log_likelihood == pytest.approx(expected, rel=1e-12)


def test_a_parameter_that_walks_goes_where_the_outputs_pull_it(backend: str) -> None:
    """A load that doubles halfway is followed within a second, and no other parameter moves."""
    t = 0.05 * np.arange(201)
    load = np.where(t < 5.0, 0.5, 1.0)
    v = np.concatenate([[0.0], np.cumsum(0.05 * load[:-1])])
    s = np.concatenate([[0.0], np.cumsum(0.05 * v[:-1] + 0.5 * 0.05**2 * load[:-1])])
    y = np.column_stack([s, v + 0.3 * load, 0.5 * s - 0.7 * v])
    grid = Grid.of(CART, Record(t, np.zeros((201, 1)), y), np.ones(3))
    walks = np.array([0.0, 0.0, 0.0, 0.3])
    found = kernels_for(CART, backend).filter(grid, np.zeros(2), np.array([1.2, 0.5]), walks,
                                              np.full(3, 0.01))  # fmt: skip
    np.testing.assert_allclose(found.parameters[:100, 1], 0.5, atol=1e-9)
    np.testing.assert_allclose(found.parameters[121:, 1], 1.0, atol=0.02)
    np.testing.assert_array_equal(found.parameters[:, 0], 1.2)


def test_covariances_stay_symmetric_and_positive_whatever_the_prior(backend: str) -> None:
    """A prior 1e12 times the noise is what Joseph's form is for."""
    wide = {'P0': 1e6 * np.eye(4), 'moving': np.array([1])}
    found = cart_pass(backend, **wide, noise=np.full(3, 1e-3))
    np.testing.assert_array_equal(found.covariances, found.covariances.transpose(0, 2, 1))
    smallest = np.linalg.eigvalsh(found.covariances)[:, 0]
    assert (smallest > -1e-12 * np.linalg.norm(found.covariances, axis=(1, 2))).all()
    assert np.isfinite(found.neg2_log_likelihood)


def test_a_candidate_that_diverges_has_an_infinite_likelihood(backend: str) -> None:
    t = np.linspace(0.0, 1.0, 21)
    y = np.zeros((21, 1))
    y[1:4] = NAN
    grid = Grid.of(BLOW_UP, Record(t, None, y), np.ones(1))
    kernels = kernels_for(BLOW_UP, backend)
    for x0 in (1e3, NAN):
        found = kernels.filter(grid, np.array([x0]), np.empty(0), np.array([0.1]), np.ones(1))
        assert found.neg2_log_likelihood == np.inf
    assert np.isfinite(
        kernels.filter(grid, np.array([0.1]), np.empty(0), np.array([0.1]), np.ones(1))
        .neg2_log_likelihood
    )  # fmt: skip


def test_differences_are_central_where_their_lanes_are_free_and_keep_to_the_bounds() -> None:
    model = replace(CART, states=(Variable('s', lower=0.0, upper=5.0), CART.states[1]))
    for d, expected in ((2, True), (7, True), (8, False), (15, False), (16, False)):
        assert central(d) is expected
    differences = Differences.of(model, np.array([0, 1]))
    points, gaps = differences.spread(np.array([0.0, 7.0]))
    assert points.shape == (2, 5)
    assert points[0].tolist() == [0.0, 5e-5, 0.0, 0.0, 0.0]
    assert gaps[0] == 5e-5
    # Out of its bounds a variable is lowered only.
    np.testing.assert_allclose(points[1], [7.0, 7.0, 7.0, 7.0, 7.0 - 7e-4], rtol=1e-15)


def test_what_process_noise_needs_compiles_when_it_is_run_first(backend: str) -> None:
    assert len([*correction_rehearsed(kernels_for(CART, backend), np.array([1]))]) == 6


def arx_pass(backend: str) -> tuple[FilterPass, Any]:
    """Nodes of a discrete model, two of three without an output."""
    u = pushes(60)
    y = course(u, walk=0.5, noise=0.02)[1]
    y[np.arange(60) % 3 > 0] = np.nan
    grid = Grid.of(ARX, Record(0.1 * np.arange(60), u, y), np.ones(1))
    P0 = np.zeros((5, 5))
    P0[:2, :2] = [[0.1, 0.02], [0.02, 0.3]]
    walks = np.array([0.5, 0.1, 0.0, 0.0, 0.0])
    start, noise = np.array([0.8, 0.6]), np.array([0.02])
    found = kernels_for(ARX, backend).filter(grid, start, np.array([*WEIGHTS, B]), walks, noise, P0)
    return found, kalman_filter(u, y, start, P0[:2, :2], walks[:2], 0.02)


def test_noise_enters_a_discrete_model_at_its_nodes(backend: str) -> None:
    found, expected = arx_pass(backend)
    np.testing.assert_allclose(found.states, expected.means, rtol=1e-8, atol=1e-10)
    np.testing.assert_allclose(found.covariances, expected.covariances, rtol=1e-6, atol=1e-11)
    np.testing.assert_allclose(found.transition[:, :, :2], np.tile(F, (59, 1, 1)), atol=1e-9)


def test_likelihoods_along_a_discrete_model_are_those_of_its_filter(backend: str) -> None:
    found, _ = arx_pass(backend)
    path = LinearPath.of(found)
    walks = np.array([[0.5, 0.1, 0.0, 0.0, 0.0], [0.9, 0.0, 0.0, 0.0, 0.0]]).T
    values = path.neg2_log_likelihood(walks, np.full((1, 2), 0.02))
    assert values[0] == pytest.approx(found.neg2_log_likelihood, rel=1e-9)
    u = pushes(60)
    y = course(u, walk=0.5, noise=0.02)[1]
    y[np.arange(60) % 3 > 0] = np.nan
    other = kalman_filter(u, y, [0.8, 0.6], found.prior, [0.9, 0.0], 0.02)
    before = [found.prior, *(F @ P @ F.T + 0.1 * np.diag([0.81, 0.0]) for P in other.covariances)]
    S = np.array([P[0, 0] for P in before[:60]]) + 0.02**2
    e = other.innovations
    seen = np.isfinite(e)
    total = np.sum(np.log(S[seen]) + e[seen] ** 2 / S[seen])
    assert values[1] == pytest.approx(total, rel=1e-7)
