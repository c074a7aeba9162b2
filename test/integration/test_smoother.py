"""Tests of obs_ros.integration.smoother."""

import numpy as np
from kalman_reference import (
    CART,
    NOISE,
    PRIOR,
    WALKS,
    X0,
    P,
    cart_window,
    dense_filter,
    dense_smoother,
)

from obs_ros import Record
from obs_ros.integration.backends import kernels_for
from obs_ros.integration.filter_pass import FilterPass
from obs_ros.integration.grid import Grid
from obs_ros.integration.smoother import _smooth_in_loops, _smooth_on_arrays, smoothed


def cart_pass(backend: str, walks: np.ndarray = WALKS, prior: np.ndarray = PRIOR) -> FilterPass:
    grid = Grid.of(CART, cart_window(), np.ones(3))
    return kernels_for(CART, backend).filter(grid, X0, P, walks, NOISE, prior)


def test_the_path_is_that_of_rauch_tung_and_striebel(backend: str) -> None:
    found, record = smoothed(cart_pass(backend)), cart_window()
    means, covariances = dense_smoother(record, dense_filter(record))
    np.testing.assert_allclose(found.states, means[:, :2], rtol=1e-7, atol=1e-8)
    np.testing.assert_allclose(found.parameters[:, 1], means[:, 2], rtol=1e-7, atol=1e-8)
    np.testing.assert_array_equal(found.parameters[:, 0], P[0])
    variances = np.diagonal(covariances, axis1=1, axis2=2)
    np.testing.assert_allclose(found.variances[:, [0, 1, 3]], variances, rtol=1e-6, atol=1e-10)
    assert not found.variances[:, 2].any()


def test_at_the_last_node_smoothed_is_filtered(backend: str) -> None:
    filtered = cart_pass(backend)
    found = smoothed(filtered)
    np.testing.assert_array_equal(found.states[-1], filtered.states[-1])
    np.testing.assert_array_equal(found.variances[-1], np.diag(filtered.P))


def test_an_initial_state_that_is_given_stays_given(backend: str) -> None:
    """Its covariance is singular, which no inverse would survive."""
    found = smoothed(cart_pass(backend, prior=np.zeros((4, 4))))
    np.testing.assert_array_equal(found.states[0], X0)
    assert not found.variances[0].any()
    assert np.isfinite(found.variances).all() and (found.variances[1:, :2] > 0.0).all()


def test_a_constant_load_is_smoothed_to_a_constant(backend: str) -> None:
    record = cart_window()
    quiet = Record(record.t, record.u, np.where(np.isfinite(record.y), 1.0, np.nan))
    grid = Grid.of(CART, quiet, np.ones(3))
    found = smoothed(kernels_for(CART, backend).filter(grid, X0, P, WALKS, NOISE, PRIOR))
    np.testing.assert_allclose(found.parameters[:, 1], found.parameters[-1, 1], rtol=1e-9)
    np.testing.assert_allclose(found.variances[:, 3], found.variances[-1, 3], rtol=1e-6)


def test_loops_and_arrays_agree() -> None:
    found = cart_pass('numpy', walks=np.array([0.1, 0.0, 0.0, 0.2]))
    arguments = (
        found.transition, found.sensitivity, found.gain[:, :, found.index], found.measured,
        found.innovations, found.S, found.means, found.covariances,
    )  # fmt: skip
    a, b = ((np.empty((61, 3)), np.empty((61, 3))) for _ in range(2))
    _smooth_in_loops(*arguments, *a)
    _smooth_on_arrays(*arguments, *b)
    np.testing.assert_allclose(a, b, rtol=1e-9, atol=1e-12)
