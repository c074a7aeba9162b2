"""Tests of obs_ros.inference.jumps.linearisation."""

import numpy as np

from obs_ros.inference.jumps.linearisation import differences


def test_differences_by_hand_where_something_was_measured() -> None:
    outputs = np.array(
        [[[1.0, 1.5, 0.5], [2.0, 2.0, 3.0]], [[3.0, 4.0, 3.0], [350.0, 10.0, 349.0]]]
    )
    y = np.array([[0.5, 0.0], [0.0, 355.0]])
    weight = np.array([[2.0, 0.0], [1.0, 0.5]])
    period, taken = np.array([0.0, 360.0]), np.array([0.5, -0.25])
    residual, jacobian = differences(outputs, y, weight, period, taken)
    np.testing.assert_allclose(residual, [1.0, 3.0, -2.5])
    # By the shortest way round from 350 to 10.
    np.testing.assert_allclose(jacobian, [[2.0, 4.0], [2.0, 0.0], [20.0, 2.0]])


def test_nothing_measured_leaves_no_rows() -> None:
    nothing = np.zeros((3, 1))
    residual, jacobian = differences(np.ones((3, 1, 2)), nothing, nothing, np.zeros(1), np.ones(1))
    assert residual.shape == (0,) and jacobian.shape == (0, 1)
