"""Tests of obs_ros.integration.grid."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from plants import NAN, OSCILLATOR, with_interpolation

from obs_ros import Record, Variable
from obs_ros.integration.grid import Grid, interpolate
from obs_ros.models.three_tank import THREE_TANK

T = np.array([0.0, 1.0, 2.0, 4.0, 5.0, 8.0])
U = np.array([2.0, NAN, 4.0, NAN, 0.0, NAN])


def path(interpolation: str, t: np.ndarray = T, u: np.ndarray = U) -> tuple[list, list]:
    variable = Variable('u', interpolation=interpolation)  # type: ignore[arg-type]
    values, slopes = interpolate(t, u[:, None], (variable,))
    return values[:, 0].tolist(), slopes[:, 0].tolist()


def test_hold_keeps_the_last_value() -> None:
    assert path('hold') == ([2.0, 2.0, 4.0, 4.0, 0.0, 0.0], [0.0] * 6)


def test_linear_runs_to_the_next_sample_across_nodes_without_one_and_then_holds() -> None:
    values, slopes = path('linear')
    np.testing.assert_allclose(values, [2.0, 3.0, 4.0, 4.0 - 8.0 / 3.0, 0.0, 0.0])
    np.testing.assert_allclose(slopes, [1.0, 1.0, -4.0 / 3.0, -4.0 / 3.0, 0.0, 0.0])


def test_mean_stays_between_two_samples_and_then_holds() -> None:
    assert path('mean') == ([3.0, 3.0, 2.0, 2.0, 0.0, 0.0], [0.0] * 6)


@pytest.mark.parametrize('interpolation', ['hold', 'linear', 'mean'])
def test_a_single_sample_is_held(interpolation: str) -> None:
    assert path(interpolation, T[:3], np.array([5.0, NAN, NAN])) == ([5.0] * 3, [0.0] * 3)


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


@pytest.mark.parametrize(
    ('interval', 'steps'), [(0.4, 1), (1.0, 1), (1.009, 1), (1.02, 2), (2.5, 3), (10.0, 10)]
)
def test_an_interval_is_split_into_steps_no_longer_than_max_step_give_or_take_jitter(
    interval: float, steps: int
) -> None:
    record = Record([0.0, interval], np.zeros((2, 2)), np.zeros((2, 2)))
    assert Grid.of(THREE_TANK, record, np.ones(2)).steps.tolist() == [steps]


def test_without_max_step_every_interval_is_one_step() -> None:
    model = replace(THREE_TANK, max_step=np.inf)
    record = Record([0.0, 1.0, 1000.0], np.zeros((3, 2)), np.zeros((3, 2)))
    assert Grid.of(model, record, np.ones(2)).steps.tolist() == [1, 1]


def test_what_was_not_measured_has_no_weight() -> None:
    y = np.array([[1.0, NAN], [NAN, NAN], [3.0, 4.0]])
    grid = Grid.of(THREE_TANK, Record([0.0, 1.0, 2.0], np.zeros((3, 2)), y), np.array([0.5, 2.0]))
    assert grid.weight.tolist() == [[2.0, 0.0], [0.0, 0.0], [2.0, 0.5]]
    assert grid.y.tolist() == [[1.0, 0.0], [0.0, 0.0], [3.0, 4.0]]
    assert grid.measured.tolist() == [True, False, True]
    assert [grid.measured_values(k) for k in (0, 1, 2, 3)] == [0, 1, 1, 3]


def test_rescaled_multiplies_the_scales_only() -> None:
    grid = Grid.of(
        THREE_TANK, Record([0.0, 1.0], np.zeros((2, 2)), np.ones((2, 2))), np.array([0.5, 2.0])
    )
    again = grid.rescaled(np.array([2.0, 4.0]))
    assert again.scale.tolist() == [1.0, 8.0]
    assert again.weight.tolist() == [[1.0, 0.125]] * 2
    assert again.y is grid.y


@pytest.mark.parametrize(
    ('u', 'y', 'message'),
    [
        (1, 2, r"the record has 1 columns in u, but model 'three_tank' has 2: \['Q1', 'Q2'\]"),
        (2, 3, r"the record has 3 columns in y, but model 'three_tank' has 2: \['h1', 'h2'\]"),
    ],
)
def test_a_record_of_another_plant_is_refused(u: int, y: int, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        Grid.of(THREE_TANK, Record([0.0, 1.0], np.zeros((2, u)), np.zeros((2, y))), np.ones(2))


def test_every_input_has_its_own_interpolation() -> None:
    variables = (Variable('a'), Variable('b', interpolation='linear'))
    values, slopes = interpolate(
        np.array([0.0, 2.0]), np.array([[1.0, 1.0], [3.0, 3.0]]), variables
    )
    assert values.tolist() == [[1.0, 1.0], [3.0, 3.0]]
    assert slopes.tolist() == [[0.0, 1.0], [0.0, 0.0]]
    assert with_interpolation(OSCILLATOR, 'mean').inputs[0].interpolation == 'mean'
