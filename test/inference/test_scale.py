"""Tests of obs_ros.inference.scale."""

import numpy as np
import pytest

from obs_ros.inference.scale import Scale

# One unknown on a linear scale, from -1 to 3, and one on a log scale, from 0.1 to 10.
SCALE = Scale(np.array([-1.0, 0.1]), np.array([3.0, 10.0]), np.array([0.0, np.log(100.0)]))


def test_places_and_values_are_inverse_on_both_scales() -> None:
    z = np.array([[0.0, 0.0], [0.5, 0.5], [1.0, 1.0], [0.25, 0.75]])
    values = SCALE.values(z)
    np.testing.assert_allclose(values[:3], [[-1.0, 0.1], [1.0, 1.0], [3.0, 10.0]])
    np.testing.assert_allclose(SCALE.places(values), z, atol=1e-15)
    np.testing.assert_allclose(SCALE.places_of(values[:, 1:], 1), z[:, 1:], atol=1e-15)


def test_widths_are_those_of_logarithms_on_a_log_scale() -> None:
    np.testing.assert_allclose(SCALE.width, [4.0, 9.9])
    np.testing.assert_allclose(SCALE.unit, [4.0, np.log(100.0)])


@pytest.mark.parametrize('z', [0.1, 0.9])
def test_slopes_are_the_derivatives_of_values(z: float) -> None:
    h, place = 1e-6, np.full(2, z)
    slopes = (SCALE.values(place + h) - SCALE.values(place - h)) / (2.0 * h)
    np.testing.assert_allclose(SCALE.slopes(place), slopes, rtol=1e-6)
    assert SCALE.slopes(place[:1], 0) == pytest.approx(4.0)
