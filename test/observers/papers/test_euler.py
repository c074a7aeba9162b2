"""Tests of obs_ros.observers.papers.euler."""

import numpy as np
from plants import INTEGRATOR

from obs_ros.integration.path import Path
from obs_ros.observers.papers.euler import euler_step, mean_inputs, outputs_of

NO_SLOPE = np.zeros((3, 1))


def path(pieces: int, slope: float = 0.0) -> Path:
    """2 s at 1.0, then 1 s at 4.0; with a slope from there on."""
    dt, u = np.array([2.0, 1.0]), np.array([[1.0], [4.0], [4.0]])
    return Path(pieces, np.array([0.0, 2.0, 3.0]), dt, np.ones(2, np.int64), u, NO_SLOPE + slope)


def test_inputs_are_averaged_over_the_path_and_held_ones_stay_as_they_are() -> None:
    assert mean_inputs(path(2)) == [2.0]
    assert mean_inputs(path(1)) == [1.0]
    assert mean_inputs(path(1, slope=0.5)) == [1.5]  # in the middle of 2 s


def test_a_step_of_one_candidate_and_of_many() -> None:
    u, p = np.array([3.0]), np.array([0.5, 0.1])  # gain, drift
    np.testing.assert_allclose(euler_step(INTEGRATOR, 0.0, 0.5, np.array([1.0]), u, p), [1.8])
    many = np.array([[1.0, 2.0]])
    np.testing.assert_allclose(euler_step(INTEGRATOR, 0.0, 0.5, many, u, p), [[1.8, 2.8]])
    np.testing.assert_array_equal(outputs_of(INTEGRATOR, 0.0, many, u, p), many)
