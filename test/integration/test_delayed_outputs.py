"""Tests of obs_ros.integration.delayed_outputs."""

from dataclasses import replace

import numpy as np
import pytest
from late_inputs import CART, INTERVAL, TRUTH, VALVE, exact, measured, steps_of_input
from plants import LAG

from obs_ros import Record, solve_window
from obs_ros.integration.backends import kernels_for
from obs_ros.integration.delayed_outputs import shows_inputs
from obs_ros.integration.grid import Grid


def test_outputs_that_depend_on_inputs_are_known() -> None:
    assert shows_inputs(CART)
    assert not shows_inputs(VALVE) and not shows_inputs(LAG)


@pytest.mark.parametrize('backend', ['numba', 'numpy'])
def test_a_leap_about_a_sample_shows_in_it_or_not_as_is_measured(backend: str) -> None:
    if backend == 'numba':
        pytest.importorskip('numba')
    t = INTERVAL * np.arange(60)
    u = steps_of_input(np.random.default_rng(3), t.size)
    kernels = kernels_for(CART, backend)
    # 1 % of an interval to either side of the truth, with leaps at samples, before and after them.
    for intervals in (2.0, 1.99, 2.01, 2.5):
        y = exact(CART, t, u, intervals * INTERVAL)
        grid = Grid.of(CART, Record(t, u, y), np.ones(2))
        delays = INTERVAL * (intervals + np.array([-0.01, 0.0, 0.01]))
        p = np.array([*np.tile(TRUTH, (3, 1)).T, delays])
        _, outputs = kernels.trajectories(grid, np.ones((1, 3)), p)
        off = np.abs(outputs - y[:, :, None]).max(axis=(0, 1))
        assert off[1] < 1e-6 and off.max() < 5e-3  # leaps are of 5
        squares = kernels.squares(grid, np.array([60]), np.ones((1, 3)), p)
        assert squares.max() < 1e-3
    far = np.array([*np.tile(TRUTH, (1, 1)).T, [INTERVAL * 2.6]])
    grid = Grid.of(CART, Record(t, u, exact(CART, t, u, 2.0 * INTERVAL)), np.ones(2))
    assert kernels.squares(grid, np.array([60]), np.ones((1, 1)), far)[0, 0, 0] > 10.0


@pytest.mark.parametrize('intervals', [0.3, 1.0, 1.02, 2.5, 4.97])
def test_a_dead_time_of_an_input_that_is_measured_at_once_is_found(intervals: float) -> None:
    for seed in range(3):
        record, sigma = measured(CART, intervals, seed)
        noise = dict(zip(('y0', 'y1'), sigma.tolist(), strict=True))
        estimate = solve_window(CART, record, seed=1, noise=noise)
        assert estimate.outcome == 'converged'
        off = estimate.parameters['u.delay'] - intervals * INTERVAL
        assert abs(off) < 3.0 * estimate.stddev['u.delay']
        assert abs(off) < 0.05 * INTERVAL


def test_an_output_off_in_time_that_depends_on_inputs_is_found() -> None:
    inputs, outputs = [replace(v, delay=None) for v in CART.inputs], list(CART.outputs)
    for place, intervals in ((0, 1.0), (0, -0.4), (1, 2.0)):
        late = [replace(v, delay=(-0.2, 0.2)) if i == place else v for i, v in enumerate(outputs)]
        model = replace(CART, inputs=inputs, outputs=late, parameters=CART.parameters[:2])
        rng = np.random.default_rng(place)
        t = INTERVAL * np.arange(250)
        u = steps_of_input(rng, t.size)
        y = exact(CART, t, u, 0.0)
        # Measured before its stamp: an input that acts as much later, from the state of then.
        fine = np.unique(np.round(np.concatenate([t, t - intervals * INTERVAL]), 9))
        held = u[np.clip(np.floor(fine / INTERVAL + 1e-6), 0, t.size - 1).astype(int)]
        shifted = exact(CART, fine[fine >= 0.0], held[fine >= 0.0], 0.0)
        at = np.searchsorted(fine[fine >= 0.0], np.round(t - intervals * INTERVAL, 9))
        y[:, place] = shifted[np.clip(at, 0, len(shifted) - 1), place]
        sigma = 0.01 * y.std(axis=0)
        record = Record(t, u, y + sigma * rng.standard_normal(y.shape))
        noise = dict(zip(('y0', 'y1'), sigma.tolist(), strict=True))
        estimate = solve_window(model, record, seed=1, noise=noise)
        name = f'y{place}.delay'
        assert estimate.outcome == 'converged'
        off = estimate.parameters[name] - intervals * INTERVAL
        assert abs(off) < 3.0 * estimate.stddev[name]
