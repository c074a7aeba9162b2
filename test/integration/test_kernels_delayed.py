"""Tests of the kernel of obs_ros.integration.kernels_delayed, against its twin on NumPy."""

from dataclasses import replace

import numpy as np
import pytest
from late_inputs import CART, INTERVAL, measured
from offset_spring import measured as measured_spring
from offset_spring import plain_window, spring

from obs_ros import Record
from obs_ros.integration.backends import kernels_for
from obs_ros.integration.delayed import DelayedKernels
from obs_ros.integration.grid import Grid


def test_both_backends_agree() -> None:
    pytest.importorskip('numba')
    rng = np.random.default_rng(5)
    model = spring((-0.1, 0.1), (0.0, 0.1), max_step=0.0015)  # 14 steps in an interval
    record, sigma = measured_spring(rng, 0.03, 0.05)
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


def test_both_backends_show_inputs_in_outputs_alike() -> None:
    pytest.importorskip('numba')
    rng = np.random.default_rng(5)
    outputs = [replace(v, delay=(-0.1, 0.1)) for v in CART.outputs[:1]]
    model = replace(CART, outputs=[*outputs, *CART.outputs[1:]], parameters=CART.parameters[:2])
    record, sigma = measured(CART, 2.0, 1, samples=120)
    grid = Grid.of(model, Record(*(each[10:] for each in (record.t, record.u, record.y))), sigma)
    x0 = np.ones((1, 12))
    p = np.vstack([np.full(12, 5.0), np.full(12, 0.6), INTERVAL * rng.uniform(0.0, 4.0, 12),
                   INTERVAL * rng.choice([-1.0, 0.0, 0.99, 1.01, 1.6], 12)])  # fmt: skip
    p[2, :3] = INTERVAL * np.array([2.0, 1.99, 2.2])
    one, other = (kernels_for(model, backend) for backend in ('numba', 'numpy'))
    same = {'rtol': 1e-9, 'atol': 1e-9}
    prefixes = np.array([40, 120])
    np.testing.assert_allclose(*(k.squares(grid, prefixes, x0, p) for k in (one, other)), **same)
    np.testing.assert_allclose(*(k.grams(grid, 120, x0, p, 4) for k in (one, other)), **same)
    np.testing.assert_allclose(*(k.trajectories(grid, x0, p)[1] for k in (one, other)), **same)
