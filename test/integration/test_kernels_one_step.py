"""Tests of the kernel of one-step sensitivities, against the NumPy backend and rollouts."""

import numpy as np
import pytest

from obs_ros import Record
from obs_ros.integration.backends import kernels_for
from obs_ros.integration.grid import Grid
from obs_ros.models.three_tank import THREE_TANK

K = 12
T = np.cumsum(np.linspace(0.3, 1.4, K))
U = np.column_stack([np.linspace(5.0, 40.0, K), np.full(K, 20.0)])
MOVED = np.array([1e-6, 2e-6, 3e-6])


@pytest.mark.parametrize('repeats', [1, 6])  # one chunk of lanes, and two
def test_compiled_differences_are_those_of_numpy(repeats: int) -> None:
    pytest.importorskip('numba')
    grid = Grid.of(THREE_TANK, Record(T, U, np.zeros((K, 2))), np.ones(2))
    rng = np.random.default_rng(3)
    states = tuple(rng.uniform(20.0, 60.0, (2, K, 3)))
    p = np.array([0.5, 0.6, 0.7])
    sets = np.repeat(np.array([p, 0.9 * p])[:, :, None], 1 + 3 * repeats, axis=2)
    for j in range(3 * repeats):
        sets[:, j % 3, 1 + j] += 1e-6 * (1 + j)
    along, there = (np.arange(K) > 5).astype(np.int64), (np.arange(K) > 6).astype(np.int64)
    found, expected = (
        kernels_for(THREE_TANK, backend).one_step(grid, states, MOVED, sets, along, there)
        for backend in ('numba', 'numpy')
    )
    for each, other in zip(found, expected, strict=True):
        assert each.shape == other.shape == (len(each), each.shape[1], 3 + 3 * repeats)
        np.testing.assert_allclose(each, other, rtol=1e-6, atol=1e-13)


def test_differences_of_one_interval_by_two_rollouts() -> None:
    grid = Grid.of(THREE_TANK, Record(T, U, np.zeros((K, 2))), np.ones(2))
    kernels = kernels_for(THREE_TANK)
    x, p = np.array([50.0, 30.0, 40.0]), np.array([0.5, 0.6, 0.7])
    states = np.repeat(x[None], K, axis=0)
    sets = np.repeat(p[None, :, None], 2, axis=2)
    sets[0, 1, 1] += 1e-6
    always = np.zeros(K, dtype=np.int64)
    ends, outputs = kernels.one_step(grid, (states, states), MOVED, sets, always, always)
    one = grid.stretch(4, 5)
    plain = kernels.trajectories(one, x[:, None], p[:, None])[0][1, :, 0]
    moved = kernels.trajectories(one, x[:, None], sets[0, :, 1:])[0][1, :, 0]
    np.testing.assert_allclose(ends[4, :, 3], moved - plain, rtol=1e-6, atol=1e-13)
    # The outputs are the levels of the first two tanks.
    np.testing.assert_allclose(outputs[7], np.eye(2, 4) * np.append(MOVED, 1.0), atol=1e-13)


def test_parameters_that_change_on_the_way() -> None:
    grid = Grid.of(THREE_TANK, Record(T, U, np.zeros((K, 2))), np.ones(2))
    x, sets = np.array([[50.0], [30.0], [40.0]]), np.array([[[0.5], [0.6], [0.7]], [[0.9]] * 3])
    along, there = (np.arange(K) >= 5).astype(np.int64), (np.arange(K) > 5).astype(np.int64)
    for backend in ('numpy', None):
        kernels = kernels_for(THREE_TANK, backend)
        states, outputs = kernels.scheduled(grid, x, sets, along, there)
        before = kernels.trajectories(grid.stretch(0, 5), x, sets[0])[0]
        after = kernels.trajectories(grid.stretch(5, K - 1), before[-1], sets[1])[0]
        np.testing.assert_allclose(states, np.concatenate([before, after[1:]]), rtol=1e-12)
        np.testing.assert_allclose(outputs, states[:, :2], rtol=1e-12)
