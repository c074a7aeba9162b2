"""Tests of obs_ros.core.interpolation."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from plants import NAN

from obs_ros.core.interpolation import check_kinds, segment, segments, values_from
from obs_ros.core.model import Interpolation

T = np.array([0.0, 1.0, 2.0, 4.0, 5.0, 8.0])
U = np.array([2.0, NAN, 4.0, NAN, 0.0, NAN])


@pytest.mark.parametrize(
    ('kind', 'value', 'slope'), [('hold', 2.0, 0.0), ('mean', 5.0, 0.0), ('linear', 3.5, 1.5)]
)
def test_between_two_samples(kind: Interpolation, value: float, slope: float) -> None:
    assert segment(kind, 2.0, 8.0, 4.0, 1.0) == (value, slope)


def path(kind: Interpolation, t: np.ndarray = T, u: np.ndarray = U) -> tuple[list, list]:
    values, slopes = segments(t, u[:, None], [kind])
    return values[:, 0].tolist(), slopes[:, 0].tolist()


def test_hold_keeps_the_last_value() -> None:
    assert path('hold') == ([2.0, 2.0, 4.0, 4.0, 0.0, 0.0], [0.0] * 6)


def test_linear_runs_to_the_next_sample_across_nodes_without_one_and_then_holds() -> None:
    values, slopes = path('linear')
    np.testing.assert_allclose(values, [2.0, 3.0, 4.0, 4.0 - 8.0 / 3.0, 0.0, 0.0])
    np.testing.assert_allclose(slopes, [1.0, 1.0, -4.0 / 3.0, -4.0 / 3.0, 0.0, 0.0])


def test_mean_stays_between_two_samples_and_then_holds() -> None:
    assert path('mean') == ([3.0, 3.0, 2.0, 2.0, 0.0, 0.0], [0.0] * 6)


@pytest.mark.parametrize('kind', ['hold', 'linear', 'mean'])
def test_a_single_sample_is_held(kind: Interpolation) -> None:
    assert path(kind, T[:3], np.array([5.0, NAN, NAN])) == ([5.0] * 3, [0.0] * 3)


@given(
    st.lists(st.one_of(st.just(NAN), st.floats(-100.0, 100.0)), min_size=1, max_size=12),
    st.lists(st.floats(0.01, 10.0), min_size=12, max_size=12),
)
def test_linear_is_numpys_interpolation(u: list[float], gaps: list[float]) -> None:
    values = np.array([1.0, *u])
    t = np.cumsum(gaps)[: values.size - 1]
    t = np.concatenate([[0.0], t])
    known = np.isfinite(values)
    got, _ = path('linear', t, values)
    np.testing.assert_allclose(got, np.interp(t, t[known], values[known]), atol=1e-9)


def test_every_input_has_its_own_interpolation() -> None:
    values, slopes = segments(
        np.array([0.0, 2.0]), np.array([[1.0, 1.0], [3.0, 3.0]]), ['hold', 'linear']
    )
    assert values.tolist() == [[1.0, 1.0], [3.0, 3.0]]
    assert slopes.tolist() == [[0.0, 1.0], [0.0, 0.0]]


def test_kinds_are_one_known_kind_for_each_input() -> None:
    assert check_kinds(None, 2) == ('hold', 'hold')
    assert check_kinds(['mean', 'linear'], 2) == ('mean', 'linear')
    with pytest.raises(ValueError, match='1 interpolations given for 2 inputs'):
        check_kinds(['hold'], 2)
    with pytest.raises(ValueError, match="'cubic' is none of hold, linear, mean"):
        check_kinds(['cubic'], 1)


def test_a_record_that_begins_later_goes_on_with_the_same_inputs() -> None:
    t = np.arange(6.0)
    u = np.array([[1.0, NAN, 2.0, NAN, NAN, 5.0]] * 3).T
    kinds: list[Interpolation] = ['hold', 'mean', 'linear']
    for time, expected in (
        (-1.0, [1.0, 1.0, 1.0]),
        (0.5, [1.0, 1.0, 1.25]),
        (2.0, [2.0, 2.0, 2.0]),
        (4.0, [2.0, 2.0, 4.0]),
        (7.0, [5.0, 5.0, 5.0]),
    ):
        np.testing.assert_allclose(values_from(t, u, kinds, time), expected)
        inner = (t > time) & (time >= 0.0)
        if inner.any():
            later = np.concatenate([[expected], u[inner]])
            cut, whole = np.append(time, t[inner]), np.union1d(t, [time])
            samples = np.full((whole.size, 3), NAN)
            samples[np.searchsorted(whole, t)] = u
            for mine, theirs in zip(
                segments(cut, later, kinds), segments(whole, samples, kinds), strict=True
            ):
                np.testing.assert_allclose(mine, theirs[whole >= time])
