"""Tests of obs_ros.optimization.decimal_coding."""

import re
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from obs_ros.optimization.decimal_coding import (
    Base10,
    digits_of,
    whole_number,
    whole_numbers,
    write_digits,
)

PAPER = Base10.of([1.8, 0.8, -0.2], [2.3, 1.2, 0.2], 5)


@st.composite
def codings(draw: Any) -> Base10:
    """One to four traits, from millionths to millions, positive, negative or both."""
    lower, upper = [], []
    for _ in range(draw(st.integers(1, 4))):
        size = 10.0 ** draw(st.floats(-6.0, 6.0))
        low = size * draw(st.floats(-1.0, 0.9))
        lower.append(low)
        upper.append(low + size * draw(st.floats(0.01, 1.0)))
    return Base10.of(lower, upper, draw(st.integers(1, 7)))


def test_the_papers_traits_have_one_digit_before_the_point_and_four_behind() -> None:
    assert PAPER.digits == 5
    assert PAPER.scale.tolist() == [1e4, 1e4, 1e4]
    assert PAPER.signed.tolist() == [False, False, True]
    genes = PAPER.encode(np.array([[2.1, 0.8, -0.05]]))
    assert genes.tolist() == [[[0, 2, 1, 0, 0, 0], [0, 0, 8, 0, 0, 0], [1, 0, 0, 5, 0, 0]]]


def test_the_gains_of_1995_take_sixteen_digits() -> None:
    gains = Base10.of([0.0, -9.9], [9.9, -0.01], 7, signed=True)
    genes = gains.encode(np.array([[1.234567, -0.01]]))
    assert genes.size == 16
    assert genes[0].tolist() == [[0, 1, 2, 3, 4, 5, 6, 7], [1, 0, 0, 1, 0, 0, 0, 0]]


def test_every_trait_has_a_decimal_point_of_its_own() -> None:
    coding = Base10.of([100.0, 1e-4, 1000.0], [300.0, 5e-4, 1000.5], 5)
    assert coding.digits == 8  # 1000.0 to 1000.5 needs four behind the point
    values = np.array([[123.45, 3.3333e-4, 1000.4999]])
    np.testing.assert_allclose(coding.decode(coding.encode(values)), values, rtol=1e-12)


def test_ends_that_decimal_fractions_hit_are_in_range() -> None:
    ends = np.arange(1, 100) / 10.0
    coding = Base10.of(-ends, ends, 5)
    assert (coding.highest == np.rint(ends * coding.scale)).all()
    assert (coding.lowest == -coding.highest).all()
    assert coding.decode(coding.encode(ends[None])).tolist() == [ends.tolist()]


@given(codings(), st.integers(0, 2**32))
@settings(max_examples=60)
def test_what_is_written_is_read_again(coding: Base10, seed: int) -> None:
    rng = np.random.default_rng(seed)
    values = rng.uniform(coding.lower, coding.upper, (20, coding.lower.size))
    genes = coding.encode(values)
    assert genes.min() >= 0 and genes.max() <= 9 and genes[:, :, 0].max() <= 1
    read = coding.decode(genes)
    # Half of the last digit; a whole one at the ends of a range, which it need not hit.
    assert (np.abs(read - values) <= 1.0001 / coding.scale).all()
    assert (coding.encode(read) == genes).all()
    assert (digits_of(whole_numbers(genes), coding.digits) == genes).all()


@given(codings(), st.integers(0, 2**32))
@settings(max_examples=60)
def test_the_first_population_is_in_range(coding: Base10, seed: int) -> None:
    draws = np.random.default_rng(seed).random((50, coding.lower.size))
    draws[0], draws[1] = 0.0, np.nextafter(1.0, 0.0)
    genes = coding.first_population(draws)
    whole = whole_numbers(genes)
    assert ((coding.lowest <= whole) & (whole <= coding.highest)).all()
    assert (whole[0] == coding.lowest).all() and (whole[1] == coding.highest).all()
    values = coding.decode(genes)
    assert (values >= coding.lower).all() and (values <= coding.upper).all()


@pytest.mark.parametrize(
    ('lower', 'upper', 'digits', 'message'),
    [
        ([0.0], [np.inf], 5, 'ranges must be finite and rising'),
        ([1.0], [1.0], 5, 'ranges must be finite and rising'),
        ([0.0, 1.0], [1.0], 5, 'must be of one length'),
        ([0.0], [1.0], 0, 'digits must be an integer >= 1, not 0'),
        ([1e9], [1e9 + 1e-6], 5, 'the range from 1000000000.0 to 1000000000.000001 is too narrow'),
    ],
)
def test_what_cannot_be_written_is_refused(
    lower: Any, upper: Any, digits: int, message: str
) -> None:
    with pytest.raises(ValueError, match=re.escape(message)):
        Base10.of(lower, upper, digits)


def test_nan_is_refused() -> None:
    with pytest.raises(ValueError, match='NaN cannot be written'):
        PAPER.encode(np.array([[2.0, np.nan, 0.0]]))


@given(codings(), st.integers(0, 2**32))
@settings(max_examples=30)
def test_one_trait_is_read_and_written_as_many_are(coding: Base10, seed: int) -> None:
    rng = np.random.default_rng(seed)
    genes = coding.first_population(rng.random((6, coding.lower.size)))
    whole, again = whole_numbers(genes), np.empty_like(genes)
    for place, number in np.ndenumerate(whole):
        assert whole_number(genes[place]) == number
        write_digits(number, again[place])
    assert (again == genes).all()
