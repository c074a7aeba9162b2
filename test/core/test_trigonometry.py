"""Tests of obs_ros.core.trigonometry: as they are without a compiler; see test_elementary."""

import math

import numpy as np
import pytest

from obs_ros.core.trigonometry import HUGE, arctan2, cos, hypot, sin, tan

pytestmark = pytest.mark.filterwarnings('ignore::RuntimeWarning')


def test_angles_that_a_float_hardly_knows_have_no_sine() -> None:
    for function in (sin, cos, tan):
        assert np.isfinite(function(np.float64(0.99 * HUGE)))
        assert np.isnan(function(np.float64(HUGE)))
        assert np.isnan(function(np.float64(-1e300)))


def test_sines_and_cosines_are_of_every_quarter() -> None:
    x = np.linspace(-7.0, 7.0, 57)
    for found, expected in ((sin, np.sin), (cos, np.cos), (tan, np.tan)):
        np.testing.assert_allclose([found(each) for each in x], expected(x), rtol=2e-14)


@pytest.mark.parametrize('y', [-1.0, -0.0, 0.0, 2.0, math.inf])
@pytest.mark.parametrize('x', [-1.0, -0.0, 0.0, 2.0, -math.inf])
def test_angles_are_of_every_quarter(y: float, x: float) -> None:
    found = arctan2(np.float64(y), np.float64(x))
    np.testing.assert_allclose(found, np.arctan2(y, x), rtol=4e-16)
    assert np.signbit(found) == np.signbit(y)


def test_lengths_neither_overflow_nor_vanish() -> None:
    np.testing.assert_allclose(hypot(np.float64(3e300), np.float64(4e300)), 5e300, rtol=4e-16)
    np.testing.assert_allclose(hypot(np.float64(3e-300), np.float64(4e-300)), 5e-300, rtol=4e-16)
    assert hypot(np.float64(math.nan), np.float64(-math.inf)) == math.inf
