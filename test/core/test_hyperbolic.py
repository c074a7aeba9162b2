"""Tests of obs_ros.core.hyperbolic: as they are without a compiler; see test_elementary."""

import math

import numpy as np
import pytest

from obs_ros.core.hyperbolic import arccosh, half_exp, signed, tanh

pytestmark = pytest.mark.filterwarnings('ignore::RuntimeWarning')


def test_half_an_exponential_is_finite_beyond_its_end() -> None:
    np.testing.assert_allclose(half_exp(np.float64(710.4)), math.cosh(710.4), rtol=1e-12)
    assert half_exp(np.float64(711.0)) == math.inf


def test_a_sign_is_that_of_another_number_even_of_zero() -> None:
    assert [signed(2.0, x) for x in (3.0, -3.0, -0.0)] == [2.0, -2.0, -2.0]


def test_tangents_keep_small_numbers_and_end_at_one() -> None:
    for x in (1e-300, -1e-9, 0.3, 19.0, 25.0, -math.inf):
        np.testing.assert_allclose(tanh(np.float64(x)), math.tanh(x), rtol=1e-15)


def test_below_one_there_is_no_inverse_cosine() -> None:
    with np.errstate(all='ignore'):
        assert all(math.isnan(arccosh(np.float64(x))) for x in (0.9, -3.0, math.nan))
