"""Tests of obs_ros.samples.stream."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from obs_ros.samples.stream import InputStream, Stream

NAN = np.nan


def row(*values: float) -> np.ndarray:
    return np.array(values)


def test_late_samples_are_sorted_in_and_equal_stamps_refused() -> None:
    stream = Stream(1, 10)
    for stamp in (10, 20, 40):
        stream.add(stamp, row(stamp))
    assert stream.add(30, row(30))
    assert stream.add(5, row(5))
    assert not stream.add(30, row(-1))
    assert stream.stamps.tolist() == [5, 10, 20, 30, 40]
    assert stream.values[:, 0].tolist() == [5.0, 10.0, 20.0, 30.0, 40.0]


def test_arrays_do_not_grow_while_few_samples_pass_through() -> None:
    stream = Stream(1, 10_000)
    for stamp in range(1000):
        stream.add(stamp, row(stamp))
        stream.drop_until(stamp - 10)
    assert stream.nbytes == 64 * 2 * 8


@given(
    capacity=st.integers(2, 40),
    steps=st.lists(st.tuples(st.integers(0, 300), st.booleans()), max_size=300),
)
def test_stream_is_a_sorted_bounded_list(capacity: int, steps: list[tuple[int, bool]]) -> None:
    stream, model = Stream(2, capacity), {}
    bound = (2 * capacity + 2) * 3 * 8
    for stamp, drop in steps:
        values = row(stamp, -stamp)
        assert stream.add(stamp, values) == (stamp not in model)
        model.setdefault(stamp, values)
        if drop or len(stream) > capacity:
            stream.drop(1)
            del model[min(model)]
        assert stream.stamps.tolist() == sorted(model)
        assert stream.values.tolist() == [model[s].tolist() for s in sorted(model)]
        assert stream.nbytes <= bound


def test_dropped_inputs_are_remembered_per_column() -> None:
    inputs = InputStream(2, 10)
    inputs.add(10, row(1.0, 2.0))
    inputs.add(20, row(NAN, 3.0))
    inputs.add(30, row(4.0, NAN))
    assert inputs.drop_until(20) == 2
    assert inputs.before(25, 0) == (10, 1.0)
    assert inputs.before(25, 1) == (20, 3.0)
    assert inputs.before(30, 0) == (30, 4.0)
    assert inputs.after(25, 0) == (30, 4.0)
    assert np.isnan(inputs.after(25, 1)[1])
    assert np.isnan(inputs.after(30, 0)[1])


def test_a_stream_filled_at_once_is_as_one_filled_sample_by_sample() -> None:
    stamps = np.array([10, 20, 30, 40])
    values = np.array([[NAN, 1.0], [2.0, NAN], [NAN, 3.0], [4.0, 5.0]])
    for rows in (slice(None), slice(0, 1), slice(0, 0)):
        one, other = InputStream(2, 10), InputStream(2, 10)
        other.add(5, row(7.0, 7.0))
        other.fill(stamps[rows], values[rows])
        for stamp, sample in zip(stamps[rows].tolist(), values[rows], strict=True):
            one.add(stamp, sample)
        for stream in (one, other):
            stream.add(50, row(6.0, NAN))
        assert one.known_since == other.known_since
        np.testing.assert_array_equal(one.stamps, other.stamps)
        np.testing.assert_array_equal(one.values, other.values)
        for column in range(2):
            np.testing.assert_array_equal(one.before(35, column), other.before(35, column))
    assert stamps.tolist() == [10, 20, 30, 40]


def test_an_old_input_is_remembered_only_if_newer_than_what_is_known() -> None:
    inputs = InputStream(1, 10)
    inputs.add(10, row(1.0))
    inputs.add(30, row(3.0))
    inputs.drop_until(10)
    assert not inputs.remember(5, row(9.0))
    assert inputs.before(25, 0) == (10, 1.0)
    assert inputs.remember(20, row(2.0))
    assert inputs.before(25, 0) == (20, 2.0)


def test_known_since_is_when_the_last_column_got_its_first_value() -> None:
    inputs = InputStream(2, 10)
    inputs.add(10, row(1.0, NAN))
    assert inputs.known_since is None
    inputs.add(30, row(NAN, 1.0))
    assert inputs.known_since == 30
    inputs.add(20, row(NAN, 1.0))
    assert inputs.known_since == 20
    inputs.drop_until(20)
    assert inputs.known_since == 20
    inputs.drop_until(30)
    assert inputs.known_since == 30
    inputs.clear()
    assert inputs.known_since is None
    assert np.isnan(inputs.before(99, 0)[1])
