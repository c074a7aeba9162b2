"""Tests of obs_ros.core.linear_algebra."""

import numpy as np

from obs_ros.core.linear_algebra import scaled_inverse


def test_the_inverse_of_badly_scaled_matrices() -> None:
    scale = np.array([1e-8, 1.0, 1e9])
    core = np.array([[2.0, 0.5, 0.1], [0.5, 1.0, 0.2], [0.1, 0.2, 3.0]])
    found = scaled_inverse(core * np.outer(scale, scale))
    np.testing.assert_allclose(found * np.outer(scale, scale), np.linalg.inv(core), atol=1e-12)
