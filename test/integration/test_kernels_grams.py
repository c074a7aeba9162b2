"""Tests of obs_ros.integration.kernels_grams, on both backends."""

import numpy as np
import pytest
from plants import NAN, OSCILLATOR

from obs_ros import Record
from obs_ros.integration.backends import kernels_for
from obs_ros.integration.grid import Grid

SCALE = np.array([0.5, 2.0])


# Starts fill chunks of eight lanes together, and several blocks of nodes follow one another.
@pytest.mark.parametrize(('starts', 'width'), [(3, 4), (8, 7), (17, 5), (9, 1)])
@pytest.mark.parametrize('nodes', [201, 17])
def test_grams_are_products_of_residuals_and_differences(
    backend: str, nodes: int, starts: int, width: int
) -> None:
    draw = np.random.default_rng(7)
    t = np.cumsum(draw.uniform(0.01, 0.03, 201))
    y, u = draw.standard_normal((201, 2)), draw.standard_normal((201, 1))
    y[draw.random(y.shape) < 0.2] = NAN
    kernels, grid = kernels_for(OSCILLATOR, backend), Grid.of(OSCILLATOR, Record(t, u, y), SCALE)
    x0 = draw.uniform(-2.0, 2.0, (2, starts * width))
    p = draw.uniform(0.2, 2.0, (2, starts * width))
    _, outputs = kernels.trajectories(grid, x0, p)
    scaled = (grid.weight[..., None] * outputs)[:nodes].reshape(-1, starts, width)
    target = (grid.weight * grid.y)[:nodes].reshape(-1)
    gram = kernels.grams(grid, nodes, x0, p, width)
    assert gram.shape == (starts, width, width)
    for start in range(starts):
        rows = scaled[:, start] - scaled[:, start, :1]
        rows[:, 0] = scaled[:, start, 0] - target
        np.testing.assert_allclose(gram[start], rows.T @ rows, rtol=1e-11, atol=1e-11)
