"""Tests of obs_ros.core.float_bits."""

import math

import numpy as np
import pytest

from obs_ros.core.float_bits import ONE, ROUND, SIGN, bits, number, power_of_two


@pytest.mark.parametrize('value', [0.0, -1.5, math.pi, 5e-324, -math.inf])
def test_a_number_comes_back_from_its_bits(value: float) -> None:
    assert number(bits(value)) == value


def test_the_bits_of_one_and_of_a_sign_are_known_by_name() -> None:
    assert (bits(1.0), number(bits(2.5) | SIGN)) == (ONE, -2.5)


@pytest.mark.parametrize(('value', 'whole'), [(2.4, 2), (-7.6, -8), (0.5, 0), (1e9 + 0.4, 10**9)])
def test_a_number_is_rounded_by_a_sum(value: float, whole: int) -> None:
    assert (value + ROUND) - ROUND == whole
    assert bits(value + ROUND) - bits(ROUND) == whole


@pytest.mark.parametrize('k', [-1022, -1, 0, 3, 1023])
def test_powers_of_two_are_exact(k: int) -> None:
    with np.errstate(over='ignore'):
        assert power_of_two(bits(k + ROUND)) == 2.0**k
