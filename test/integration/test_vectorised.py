"""Tests of obs_ros.integration.vectorised, the oracle of the compiled kernels, by hand."""

import numpy as np
from plants import INTEGRATOR, NAN

from obs_ros import Record
from obs_ros.integration.grid import Grid
from obs_ros.integration.vectorised import NumpyKernels

KERNELS = NumpyKernels(INTEGRATOR)
# x' = gain u + drift: 1, 3, 5 and 1, 1.5, 2 at the nodes.
X0, P = np.array([[1.0, 1.0]]), np.array([[1.0, 0.0], [0.0, 0.5]])
GRID = Grid.of(
    INTEGRATOR,
    Record(np.array([0.0, 1.0, 2.0]), np.full(3, 2.0), np.array([1.0, 2.0, NAN])),
    np.array([0.5]),
)


def test_states_and_outputs_at_every_node() -> None:
    states, outputs = KERNELS.trajectories(GRID, X0, P)
    np.testing.assert_allclose(states[:, 0], [[1.0, 1.0], [3.0, 1.5], [5.0, 2.0]])
    np.testing.assert_array_equal(outputs, states)


def test_squares_from_prefix_to_prefix_without_what_was_not_measured() -> None:
    squares = KERNELS.squares(GRID, np.array([1, 2, 3]), X0, P)
    np.testing.assert_allclose(squares[:, 0], [[0.0, 0.0], [4.0, 1.0], [0.0, 0.0]])


def test_products_of_residuals_and_of_differences_from_the_base() -> None:
    gram = KERNELS.grams(GRID, 3, X0, P, 2)
    np.testing.assert_allclose(gram, [[[4.0, -6.0], [-6.0, 9.0]]])
