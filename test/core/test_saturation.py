"""Sensors at the ends of their range, and actuators that clip."""

import math
from dataclasses import replace

import numpy as np
import pytest

from obs_ros import Variable
from obs_ros.core.saturation import (
    applied,
    at_an_end,
    contradicting,
    ends_of,
    has_range,
    ranges,
    unsaturated,
)

NAN, INF = math.nan, math.inf
LEVEL = Variable('level', 'V', range=(0.0, 10.0))
OUTPUTS = (LEVEL, Variable('flow', range=(-INF, 3.0)), Variable('free'))


def test_ranges_are_open_where_nothing_limits() -> None:
    low, high = ranges(OUTPUTS)
    assert low.tolist() == [0.0, -INF, -INF] and high.tolist() == [10.0, 3.0, INF]
    assert has_range(OUTPUTS) and not has_range(OUTPUTS[2:])


def test_without_ranges_the_very_same_array_comes_back() -> None:
    y = np.array([1.0, NAN])
    free = (Variable('a'), Variable('b'))
    assert ends_of(free, y) is None and unsaturated(free, y) is y
    assert applied(free, y) is y and contradicting(free, y, y) is y


@pytest.mark.parametrize('shown', [10.0, 10.0 - 1e-9, 10.0 + 1e-9, 12.0])
def test_a_sensor_at_or_beyond_an_end_is_saturated(shown: float) -> None:
    ends = ends_of(OUTPUTS, np.array([shown, 1.0, 1e9]))
    assert ends is not None
    assert ends.saturated.tolist() == [True, False, False]
    assert ends.measured(np.array([shown, 1.0, 1e9])).tolist() == [10.0, 1.0, 1e9]


def test_what_is_not_measured_is_not_saturated() -> None:
    ends = ends_of(OUTPUTS, np.array([NAN, NAN, NAN]))
    assert ends is not None and not ends.saturated.any()


def test_a_coarse_sensor_is_saturated_within_half_a_step_of_its_end() -> None:
    coarse = (replace(LEVEL, resolution=0.3),)
    for shown, saturated in ((9.9, True), (9.6, False), (0.0, True), (0.3, False)):
        ends = ends_of(coarse, np.array([shown]))
        assert ends is not None and ends.saturated[0] == saturated


def test_outputs_are_compared_from_inside_the_range_only() -> None:
    y = np.array([[10.0, 3.0, 5.0], [0.0, 1.0, 5.0]])
    ends = ends_of(OUTPUTS, y)
    assert ends is not None
    outputs = np.array([[12.0, 2.0, 9.0], [-1.0, 7.0, NAN]])
    np.testing.assert_array_equal(ends.shown(outputs), [[10.0, 2.0, 9.0], [0.0, 7.0, NAN]])
    np.testing.assert_array_equal(
        ends.beyond(outputs), [[True, False, False], [True, False, False]]
    )
    candidates = np.stack([outputs, outputs + 0.5], axis=2)
    np.testing.assert_array_equal(ends.shown(candidates)[:, :, 0], ends.shown(outputs))
    assert ends[1:].saturated.tolist() == [[True, False, False]]


def test_only_what_may_contradict_is_left_of_an_output() -> None:
    y = np.array([10.0 + 1e-8, 3.0, 5.0])
    inside = contradicting(OUTPUTS, y, np.array([9.0, 2.0, 0.0]))
    assert inside.tolist() == [10.0, 3.0, 5.0]
    beyond = contradicting(OUTPUTS, y, np.array([10.0, 4.0, 0.0]))
    np.testing.assert_array_equal(beyond, [NAN, NAN, 5.0])


def test_an_actuator_clips_and_what_is_missing_stays_so() -> None:
    inputs = (Variable('valve', range=(0.0, 1.0)), Variable('pump'))
    u = np.array([[1.5, 7.0], [NAN, -7.0], [-0.5, NAN]])
    np.testing.assert_array_equal(applied(inputs, u), [[1.0, 7.0], [NAN, -7.0], [0.0, NAN]])
    assert u[0, 0] == 1.5


def test_an_end_is_where_a_sensor_saturates() -> None:
    y = np.array([1.0, 2.0, 3.0])
    assert at_an_end(OUTPUTS, y).tolist() == [10.0, 3.0, 3.0]
    assert at_an_end((Variable('y', range=(2.0, INF)),), y[:1]).tolist() == [2.0]
