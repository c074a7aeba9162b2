"""Rollouts beside saturated sensors: the NumPy backend is the oracle of the compiled one."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from kalman_reference import CART, NOISE, PRIOR, WALKS, X0, P, cart_window

from obs_ros.core.record import Record
from obs_ros.core.typing import Array
from obs_ros.integration.backends import kernels_for
from obs_ros.integration.filter_pass import FilterPass
from obs_ros.integration.filter_step import LiveFilter
from obs_ros.integration.grid import Grid
from obs_ros.integration.path import Path
from obs_ros.integration.stepper import stepper_for

RANGES = ((-0.3, 0.4), (-np.inf, 0.2), None)
RANGED = replace(
    CART, outputs=[replace(v, range=ends) for v, ends in zip(CART.outputs, RANGES, strict=True)]
)
rng = np.random.default_rng(4)
CANDIDATES = 21
STATES = np.array(X0)[:, None] + 0.3 * rng.standard_normal((2, CANDIDATES))
PARAMETERS = np.array(P)[:, None] * (1.0 + 0.2 * rng.standard_normal((2, CANDIDATES)))


def window() -> Record:
    """The window of the cart as saturated sensors show it, some of them a little beyond."""
    record = cart_window()
    y = record.y.copy()
    for i, ends in enumerate(RANGES):
        if ends is not None:
            y[:, i] = np.clip(y[:, i], *ends) + 1e-9 * (i - 0.5)
    return record.with_outputs(y)


def grid_of(model: Any = RANGED) -> Grid:
    return Grid.of(model, window(), np.array(NOISE))


def shown_by_hand(outputs: Array, y: Array) -> Array:
    """Outputs (K, r, B), those at the ends of a range that the sensor shows cut off there."""
    outputs = outputs.copy()
    for i, ends in enumerate(RANGES):
        if ends is None:
            continue
        low, high = y[:, i] <= ends[0] + 1e-6, y[:, i] >= ends[1] - 1e-6
        outputs[high, i] = np.minimum(outputs[high, i], ends[1])
        outputs[low, i] = np.maximum(outputs[low, i], ends[0])
    return outputs


def test_the_window_has_saturated_samples_on_every_side() -> None:
    ends = grid_of().ends
    assert ends is not None
    assert (np.isfinite(ends.high).sum(axis=0)[:2] > 5).all()
    assert np.isfinite(ends.low).sum(axis=0)[0] > 5 and not ends.saturated[:, 2].any()


def test_squares_are_those_of_one_sided_residuals(backend: str) -> None:
    grid, kernels = grid_of(), kernels_for(RANGED, backend)
    outputs = kernels.trajectories(grid, STATES, PARAMETERS)[1]
    residuals = grid.weight[:, :, None] * (shown_by_hand(outputs, grid.y) - grid.y[:, :, None])
    found = kernels.squares(grid, np.array([20, grid.t.size]), STATES, PARAMETERS)
    wanted = [(residuals[part] ** 2).sum(axis=0) for part in (slice(20), slice(20, None))]
    np.testing.assert_allclose(found, wanted, rtol=1e-9)
    free = kernels_for(CART, backend).squares(grid_of(CART), np.array([61]), STATES, PARAMETERS)
    assert (found.sum(axis=0)[:2] < free[0][:2]).all() and (free[0][:2] > 100.0).any()


def test_grams_are_those_of_one_sided_residuals(backend: str) -> None:
    grid, kernels = grid_of(), kernels_for(RANGED, backend)
    outputs = shown_by_hand(kernels.trajectories(grid, STATES, PARAMETERS)[1], grid.y)
    rows = (grid.weight[:, :, None] * outputs).reshape(-1, CANDIDATES)
    columns = np.column_stack(
        [rows[:, 0] - (grid.weight * grid.y).ravel(), rows[:, 1:] - rows[:, :1]]
    )
    found = kernels.grams(grid, grid.t.size, STATES, PARAMETERS, CANDIDATES)[0]
    np.testing.assert_allclose(found, columns.T @ columns, rtol=1e-9, atol=1e-6)


def passed(backend: str) -> FilterPass:
    return kernels_for(RANGED, backend).filter(
        grid_of(), np.array(X0), np.array(P), WALKS, NOISE, PRIOR
    )


def test_the_filter_takes_a_saturated_sensor_for_silent_where_the_model_is_beyond() -> None:
    found, other = passed('numpy'), passed('numba')
    for name in ('measured', 'S', 'gain', 'cross', 'innovations', 'means', 'covariances'):
        one, two = getattr(found, name), getattr(other, name)
        np.testing.assert_allclose(two, one, rtol=1e-8, atol=1e-10, err_msg=name)
    grid = grid_of()
    silent = (grid.weight > 0.0) & ~found.measured
    assert grid.ends is not None and (grid.ends.saturated | ~silent).all()
    assert 5 < silent.sum() < grid.ends.saturated.sum()
    assert not found.gain[silent].any() and np.isfinite(found.S[silent]).all()
    assert np.isfinite(found.neg2_log_likelihood)


def test_corrected_rollouts_are_one_sided_too() -> None:
    found = passed('numpy')
    grid = grid_of().injected(found.injection, found.S)
    assert np.isfinite(grid.weight).all()
    results = []
    for backend in ('numpy', 'numba'):
        kernels = kernels_for(RANGED, backend)
        results.append((
            kernels.squares(grid, np.array([grid.t.size]), STATES, PARAMETERS),
            kernels.grams(grid, grid.t.size, STATES, PARAMETERS, 3),
            *kernels.paths(grid, STATES, PARAMETERS),
        ))  # fmt: skip
    for one, two in zip(*results, strict=True):
        np.testing.assert_allclose(two, one, rtol=1e-9, atol=1e-9)
    at_hand = kernels_for(RANGED, 'numpy').paths(grid, np.array(X0)[:, None], np.array(P)[:, None])
    silent = (grid.weight > 0.0) & ~found.measured
    np.testing.assert_allclose((grid.y - at_hand[2][:, :, 0])[silent], 0.0, atol=1e-9)


@pytest.mark.parametrize('side', [0, 1])
def test_a_diverged_candidate_is_known_beside_a_saturated_sensor(backend: str, side: int) -> None:
    states = STATES.copy()
    states[side, 3] = np.nan
    squares = (
        kernels_for(RANGED, backend)
        .squares(grid_of(), np.array([61]), states, PARAMETERS)[0]
        .sum(axis=0)
    )
    assert np.isnan(squares[3]) and np.isfinite(np.delete(squares, 3)).all()


def test_live_filters_take_saturated_sensors_alike() -> None:
    """As the pass does, from output to output; both backends, and without writing into outputs."""
    grid, found = grid_of(), passed('numpy')
    y = np.where(grid.weight > 0.0, grid.y, np.nan)
    y.flags.writeable = False
    lives = []
    for backend in ('numpy', 'numba'):
        stepper = stepper_for(RANGED, backend)
        live = LiveFilter.of(RANGED, X0, P, PRIOR, WALKS, NOISE, np.array([0, 1]))
        silent = np.zeros(y.shape, dtype=bool)
        for k in range(1, 61):
            part = grid.stretch(k - 1, k)
            path = Path(1, part.t, np.diff(part.t), part.steps, part.u, 0.0 * part.u)
            stepper.filter(live, path, y[k])
            silent[k] = np.isfinite(y[k]) & np.isnan(live.innovation)
            assert (np.isnan(live.S) == np.isnan(live.innovation)).all()
        lives.append((live.x, live.p, live.P, silent))
    for one, two in zip(*lives, strict=True):
        np.testing.assert_allclose(two, one, rtol=1e-8, atol=1e-10)
    assert grid.ends is not None and (grid.ends.saturated | ~lives[0][3]).all()
    assert lives[0][3].sum() > 5 and found.measured.any()
