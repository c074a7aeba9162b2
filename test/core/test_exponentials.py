"""Tests of obs_ros.core.exponentials: as they are without a compiler; see test_elementary."""

import math

import numpy as np
import pytest

from obs_ros.core.exponentials import exp, log2, logarithm, power, special_log, split

pytestmark = pytest.mark.filterwarnings('ignore::RuntimeWarning')


@pytest.mark.parametrize('x', [1.0, 0.75, 1e300, 3e-310, 5e-324, math.sqrt(0.5)])
def test_a_number_is_split_at_a_power_of_two(x: float) -> None:
    m, k = split(x)
    assert math.sqrt(0.5) * 0.999999 < m < math.sqrt(2.0)
    assert math.ldexp(m, int(k)) == x
    np.testing.assert_allclose(logarithm(m, k), math.log(x), rtol=4e-16)


def test_binary_logarithms_of_powers_of_two_are_exact() -> None:
    assert [float(log2(np.float64(2.0) ** k)) for k in range(-1074, 1024)] == [*range(-1074, 1024)]


def test_logarithms_of_what_is_no_positive_number() -> None:
    found = [special_log(x, 7.0) for x in (1.0, 0.0, -1.0, math.inf, math.nan)]
    np.testing.assert_array_equal(found, [7.0, -math.inf, math.nan, math.inf, math.nan])


def test_exponentials_reach_the_ends_of_the_range() -> None:
    for x in (709.7, -745.0, -708.6, 0.0):
        np.testing.assert_allclose(exp(np.float64(x)), math.exp(x), rtol=1e-13, atol=5e-324)
    assert (exp(np.float64(709.79)), exp(np.float64(-745.2))) == (math.inf, 0.0)


def test_powers_of_negative_numbers_have_the_sign_of_the_exponent_s_parity() -> None:
    values = [float(power(np.float64(-2.0), np.float64(y))) for y in (3.0, 2.0, -1.0, 0.0)]
    np.testing.assert_allclose(values, [-8.0, 4.0, -0.5, 1.0], rtol=1e-13)
    assert math.isnan(power(np.float64(-2.0), np.float64(0.5)))
