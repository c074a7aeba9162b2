"""Tests of obs_ros.integration.grid."""

from dataclasses import replace

import numpy as np
import pytest
from arx import ARX
from plants import NAN

from obs_ros import Record
from obs_ros.integration.grid import Grid, steps_within
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


def test_saturated_sensors_show_the_very_ends_of_their_range_and_are_no_values() -> None:
    y = np.array([[10.0 + 1e-7, 5.0], [4.0, NAN], [NAN, 5.0]])
    outputs = (replace(THREE_TANK.outputs[0], range=(0.0, 10.0)), THREE_TANK.outputs[1])
    model = replace(THREE_TANK, outputs=outputs)
    grid = Grid.of(model, Record([0.0, 1.0, 2.0], np.zeros((3, 2)), y), np.array([0.5, 2.0]))
    assert grid.y.tolist() == [[10.0, 5.0], [4.0, 0.0], [0.0, 5.0]]
    assert [grid.measured_values(k) for k in (0, 1, 2, 3)] == [0, 1, 2, 3]
    np.testing.assert_array_equal(grid.values, [[NAN, 5.0], [4.0, NAN], [NAN, 5.0]])
    np.testing.assert_array_equal(
        grid.residuals(np.array([[9.0, 6.0], [12.0, 0.0], [0.0, 0.0]])),
        [[-2.0, 0.5], [16.0, NAN], [NAN, -2.5]],
    )
    np.testing.assert_array_equal(
        grid.residuals(np.array([[11.0, 6.0], [4.0, 0.0], [0.0, 0.0]])),
        [[NAN, 0.5], [0.0, NAN], [NAN, -2.5]],
    )
    assert grid.stretch(1, 2).measured_values(2) == 2
    assert grid.shown(np.full((3, 2, 4), 20.0))[:, 0, 0].tolist() == [10.0, 20.0, 20.0]


def test_actuators_clip_inputs_and_rounding_is_noted() -> None:
    model = replace(
        THREE_TANK,
        inputs=(replace(THREE_TANK.inputs[0], range=(0.0, 50.0)), THREE_TANK.inputs[1]),
        outputs=(replace(THREE_TANK.outputs[0], resolution=0.6), THREE_TANK.outputs[1]),
    )
    u = np.array([[60.0, 60.0], [-5.0, -5.0]])
    grid = Grid.of(model, Record([0.0, 1.0], u, np.zeros((2, 2))), np.ones(2))
    assert grid.u.tolist() == [[50.0, 60.0], [0.0, -5.0]]
    np.testing.assert_allclose(grid.rounding, [0.6 / np.sqrt(12.0), 0.0])


def test_the_models_time_counts_from_the_windows_start_where_it_is_asked_to() -> None:
    record = Record([1e9, 1e9 + 1.0, 1e9 + 2.0], np.zeros((3, 2)), np.ones((3, 2)))
    stamped = Grid.of(THREE_TANK, record, np.ones(2))
    assert stamped.clock is stamped.t
    model = replace(THREE_TANK, time='window')
    grid = Grid.of(model, record, np.ones(2))
    assert grid.clock.tolist() == [0.0, 1.0, 2.0]
    assert grid.stretch(1, 2).clock.tolist() == [1.0, 2.0]
    assert Grid.of(model, record, np.ones(2), 1e9 - 5.0).clock.tolist() == [5.0, 6.0, 7.0]


def test_a_discrete_model_takes_as_many_steps_as_periods_fit_best() -> None:
    steps = steps_within(ARX, np.array([0.004, 0.05, 0.149, 0.151, 100.04, 1e4 * 0.1003]))
    np.testing.assert_array_equal(steps, [1, 1, 1, 2, 1000, 10030])
    t = np.array([0.0, 0.1, 0.4])
    grid = Grid.of(ARX, Record(t, np.zeros(3), np.zeros(3)), np.ones(1))
    assert grid.discrete and grid.steps.tolist() == [1, 3]
