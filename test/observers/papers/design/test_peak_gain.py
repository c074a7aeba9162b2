"""Tests of obs_ros.observers.papers.design.peak_gain."""

import numpy as np
import pytest

from obs_ros.observers.papers.design.peak_gain import peak_gain
from obs_ros.observers.papers.design.plants import LipschitzPlant


def test_the_measured_peak_gain_is_that_of_the_closed_form() -> None:
    """x' = -2 x + 0.5 sin x + eta, y = x: 1 / (2 + L - 0.5) at rest, where phi is steepest."""
    one = np.ones((1, 1))
    plant = LipschitzPlant(-2.0 * one, one, one, one, one, 0.5, np.ones(1), 1.0)
    assert peak_gain(plant, np.array([[3.0]])) == pytest.approx(1.0 / 4.5, rel=1e-6)


def test_of_two_slopes_the_worse_counts() -> None:
    """Two first-order plants side by side: 1 / (3 - 1) and 1 / (4 - 2), each with its own phi."""
    A, B, C = np.diag([-3.0, -4.0]), np.eye(2), np.eye(2)
    plant = LipschitzPlant(A, B, C, np.eye(2), np.diag([1.0, 3.0]), 1.0, np.ones(2), 1.0)
    assert peak_gain(plant, np.zeros((2, 2))) == pytest.approx(1.0 / (4.0 - 3.0), rel=1e-6)
