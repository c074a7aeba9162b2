"""Tests of obs_ros.core.record."""

import dataclasses
import re

import numpy as np
import pytest

from obs_ros.core.record import Record

T = np.arange(4.0)
NAN = np.nan


def test_one_input_and_one_output_may_come_as_vectors() -> None:
    record = Record(T, [1, 2, 3, 4], T + 5, stamp=3_000_000_000)
    assert record.u.shape == record.y.shape == (4, 1)
    np.testing.assert_array_equal(record.u[:, 0], [1.0, 2.0, 3.0, 4.0])
    np.testing.assert_array_equal(record.y[:, 0], [5.0, 6.0, 7.0, 8.0])
    assert record.stamp == 3_000_000_000


@pytest.mark.parametrize('u', [None, [], np.empty((4, 0)), np.empty((0, 0))])
def test_a_plant_without_inputs_has_no_input_columns(u: object) -> None:
    assert Record(T, u, T).u.shape == (4, 0)  # type: ignore[arg-type]


def test_arrays_are_read_only_copies() -> None:
    t, u, y = T.copy(), np.zeros((4, 2)), np.zeros((4, 1))
    record = Record(t, u, y)
    t[0], u[0], y[0] = -7.0, 7.0, 7.0
    assert (record.t[0], record.u[0, 0], record.y[0, 0]) == (0.0, 0.0, 0.0)
    for array in (record.t, record.u, record.y):
        with pytest.raises(ValueError, match='read-only'):
            array[0] = 1.0
    with pytest.raises(dataclasses.FrozenInstanceError):
        record.t = t  # type: ignore[misc]


def test_missing_values_and_an_output_never_measured_are_allowed() -> None:
    record = Record(T, [1, NAN, NAN, 2], np.column_stack([T, np.full(4, NAN)]))
    assert np.isnan(record.u[:, 0]).tolist() == [False, True, True, False]
    assert np.isnan(record.y[:, 1]).all()


def test_replace_validates_again() -> None:
    record = Record(T, None, T)
    assert dataclasses.replace(record, stamp=5).stamp == 5
    with pytest.raises(ValueError, match='y has 3 rows but t has 4'):
        dataclasses.replace(record, y=np.zeros((3, 1)))


@pytest.mark.parametrize(
    ('t', 'u', 'y', 'message'),
    [
        ([1.0], [1.0], [1.0], 'at least two times in one dimension, not shape (1,)'),
        (np.zeros((4, 1)), None, T, 'not shape (4, 1)'),
        ([0, 1, NAN, 3], None, T, 't[2] is nan'),
        ([0, 1, 2, np.inf], None, T, 't[3] is inf'),
        ([0, 1, 1, 3], None, T, 't[2] = 1.0 s does not come after t[1] = 1.0 s'),
        ([0, 2, 1, 3], None, T, 't[2] = 1.0 s does not come after t[1] = 2.0 s'),
        (T, np.zeros(3), T, 'u has 3 rows but t has 4'),
        (T, None, np.zeros((5, 2)), 'y has 5 rows but t has 4'),
        (T, np.zeros((3, 0)), T, 'u has 3 rows but t has 4'),
        (T, np.zeros((4, 1, 1)), T, 'u must have shape (4,) or (4, n), not (4, 1, 1)'),
        (T, 3.0, T, 'u must have shape (4,) or (4, n), not ()'),
        (T, [0, 0, -np.inf, 0], T, 'u[2, 0] is -inf: use NaN'),
        (T, None, [[0, 1], [0, np.inf], [0, 0], [0, 0]], 'y[1, 1] is inf: use NaN'),
        (T, [NAN, 1, 2, 3], T, 'input column 0 has no value at the first sample'),
        (T, [[1, NAN], *[[1, 1]] * 3], T, 'input column 1 has no value at the first sample'),
        (T, None, np.full((4, 2), NAN), 'y has no measured value'),
        (T, None, [], 'y has no measured value'),
    ],
)
def test_what_is_wrong_is_named(t: object, u: object, y: object, message: str) -> None:
    with pytest.raises(ValueError, match=re.escape(message)):
        Record(t, u, y)  # type: ignore[arg-type]
