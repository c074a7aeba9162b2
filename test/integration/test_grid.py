"""Tests of obs_ros.integration.grid."""

from dataclasses import replace

import numpy as np
import pytest
from plants import NAN

from obs_ros import Record
from obs_ros.integration.grid import Grid
from obs_ros.models.three_tank import THREE_TANK


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


def test_the_models_time_counts_from_the_windows_start_where_it_is_asked_to() -> None:
    record = Record([1e9, 1e9 + 1.0, 1e9 + 2.0], np.zeros((3, 2)), np.ones((3, 2)))
    stamped = Grid.of(THREE_TANK, record, np.ones(2))
    assert stamped.clock is stamped.t
    model = replace(THREE_TANK, time='window')
    grid = Grid.of(model, record, np.ones(2))
    assert grid.clock.tolist() == [0.0, 1.0, 2.0]
    assert grid.stretch(1, 2).clock.tolist() == [1.0, 2.0]
    assert Grid.of(model, record, np.ones(2), 1e9 - 5.0).clock.tolist() == [5.0, 6.0, 7.0]
