"""Tests of the kernel of obs_ros.integration.kernels_delayed, against its twin on NumPy."""

import numpy as np
import pytest
from offset_spring import measured, plain_window, spring

from obs_ros.integration.backends import kernels_for
from obs_ros.integration.delayed import DelayedKernels
from obs_ros.integration.grid import Grid


def test_both_backends_agree() -> None:
    pytest.importorskip('numba')
    rng = np.random.default_rng(5)
    model = spring((-0.1, 0.1), (0.0, 0.1), max_step=0.0015)  # 14 steps in an interval
    record, sigma = measured(rng, 0.03, 0.05)
    grid = Grid.of(model, plain_window(record), sigma)
    x0 = rng.uniform(-1.0, 1.0, (2, 10))
    p = np.vstack([rng.uniform(20.0, 60.0, 10), rng.uniform(0.5, 1.0, 10),
                   rng.uniform(0.0, 0.1, 10), rng.uniform(-0.1, 0.1, 10)])  # fmt: skip
    one, other = (kernels_for(model, backend) for backend in ('numba', 'numpy'))
    assert isinstance(one, DelayedKernels) and isinstance(other, DelayedKernels)
    prefixes = np.array([40, 100, 151])
    same = {'rtol': 1e-9, 'atol': 1e-9}
    np.testing.assert_allclose(*(k.squares(grid, prefixes, x0, p) for k in (one, other)), **same)
    np.testing.assert_allclose(*(k.grams(grid, 120, x0, p, 5) for k in (one, other)), **same)
    for part in range(2):
        np.testing.assert_allclose(
            *(k.trajectories(grid, x0, p)[part] for k in (one, other)), **same
        )
    sets = np.array([p, 1.1 * p, 0.9 * p])
    order = np.minimum(np.arange(151) // 60, 2)
    for part in range(2):
        np.testing.assert_allclose(
            *(k.scheduled(grid, x0, sets, order, order)[part] for k in (one, other)), **same
        )
