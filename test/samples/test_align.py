"""Tests of obs_ros.samples.align."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from obs_ros.core.model import Interpolation
from obs_ros.core.typing import Array
from obs_ros.samples.align import align
from obs_ros.samples.stream import InputStream, Stream

NAN = np.nan
S = 10**9


def streams(outputs: dict[int, float], inputs: dict[int, float]) -> tuple[Stream, InputStream]:
    """Two streams of one column each, from stamp in s to value."""
    y, u = Stream(1, 1000), InputStream(1, 1000)
    for stream, samples in ((y, outputs), (u, inputs)):
        for second, value in samples.items():
            stream.add(second * S, np.array([value]))
    return y, u


@pytest.mark.parametrize(
    ('kind', 'start', 'end'), [('hold', 0.0, NAN), ('linear', 5.0, 60.0), ('mean', 0.0, 80.0)]
)
def test_ends_between_two_inputs(kind: Interpolation, start: float, end: float) -> None:
    y, u = streams({1: 1.0, 3: 3.0, 5: 5.0}, {0: 0.0, 2: 10.0, 4: 40.0, 6: 80.0})
    record = align(y, u, 5 * S, (kind,))
    assert record is not None
    np.testing.assert_allclose(record.t, [1, 2, 3, 4, 5])
    np.testing.assert_array_equal(record.y[:, 0], [1, NAN, 3, NAN, 5])
    np.testing.assert_array_equal(record.u[:, 0], [start, 10, NAN, 40, end])
    assert record.stamp == 5 * S


def test_a_record_has_the_inputs_of_the_past_that_it_asks_for() -> None:
    y, u = streams({5: 1.0, 6: 1.0}, {0: 0.0, 2: 10.0, 4: 40.0, 6: 80.0})
    record = align(y, u, 6 * S, ('mean',), 2 * S)
    assert record is not None and record.past is not None
    t, values = record.past
    # From 3 s on, where the input is half way from 10 to 40, to the first output.
    assert t.tolist() == [3, 4, 5] and record.t[0] == 5.0
    np.testing.assert_array_equal(values[:, 0], [10, 40, NAN])
    alone = align(y, u, 6 * S, ('mean',))
    assert alone is not None and alone.past is None
    assert record.with_outputs(2.0 * record.y).past is record.past


def test_a_node_keeps_the_values_of_all_samples_that_share_it() -> None:
    y, u = Stream(2, 10), InputStream(0, 10)
    for stamp, values in (
        (10**18, [1.0, NAN]),
        (10**18 + 50, [NAN, 2.0]),
        (10**18 + S, [3.0, 4.0]),
    ):
        y.add(stamp, np.array(values))
    record = align(y, u, 2 * 10**18, ())
    assert record is not None
    assert record.y.tolist() == [[1.0, 2.0], [3.0, 4.0]]


def test_a_dropped_input_still_counts_at_the_start() -> None:
    y, u = streams({4: 1.0, 6: 1.0}, {0: 10.0, 8: 50.0})
    u.drop(1)
    hold, linear = align(y, u, 9 * S, ('hold',)), align(y, u, 9 * S, ('linear',))
    assert hold is not None
    assert linear is not None
    np.testing.assert_array_equal(hold.u[:, 0], [10, NAN])
    np.testing.assert_allclose(linear.u[:, 0], [30, 40])


@pytest.mark.parametrize(('kind', 'end'), [('hold', NAN), ('linear', 2.0), ('mean', NAN)])
def test_without_a_later_input_the_last_one_holds(kind: Interpolation, end: float) -> None:
    y, u = streams({0: 1.0, 5: 1.0}, {0: 1.0, 3: 2.0})
    record = align(y, u, 5 * S, (kind,))
    assert record is not None
    np.testing.assert_array_equal(record.u[:, 0], [1, 2, end])


def test_outputs_after_the_end_are_left_out_and_one_is_too_few() -> None:
    y, u = streams({0: 1.0, 5: 1.0, 9: 1.0}, {0: 1.0, 8: 2.0})
    record = align(y, u, 8 * S, ('hold',))
    assert record is not None
    assert record.t.tolist() == [0.0, 5.0]
    assert record.stamp == 5 * S
    assert align(y, u, 4 * S, ('hold',)) is None


def test_held_inputs_that_stay_as_they_were_are_no_nodes_of_their_own() -> None:
    y, u = Stream(1, 100), InputStream(2, 100)
    for second in (1, 4, 7, 10):
        y.add(second * S, np.array([0.0]))
    for second, values in ((0, [5, 1]), (2, [5, 1]), (3, [5, NAN]), (4, [5, 1]), (5, [5, 2]),
                           (6, [NAN, 2]), (8, [6, 2]), (9, [5, NAN])):  # fmt: skip
        u.add(second * S, np.array(values, dtype=np.float64))
    held, straight = (align(y, u, 10 * S, ('hold', kind)) for kind in ('hold', 'linear'))
    assert held is not None and straight is not None
    # At 2, 3 and 6 s nothing changes; at 4 s the outputs have a node, with the inputs that came.
    assert held.t.tolist() == [1, 4, 5, 7, 8, 9, 10]
    np.testing.assert_array_equal(
        held.u.T, [[5, 5, 5, NAN, 6, 5, NAN], [1, 1, 2, NAN, 2, NAN, NAN]]
    )
    assert straight.t.tolist() == [1, 2, 4, 5, 6, 7, 8, 9, 10]


def test_samples_closer_than_a_float_of_seconds_share_a_node() -> None:
    now = 1_760_000_000 * S
    y, u = Stream(1, 10), InputStream(1, 10)
    for stamp in (now, now + S):
        y.add(stamp, np.array([1.0]))
        u.add(stamp + 20, np.array([2.0]))
    u.add(now - S, np.array([7.0]))
    record = align(y, u, now + 2 * S, ('hold',))
    assert record is not None
    assert record.t.tolist() == [1.76e9, 1.76e9 + 1]
    assert record.u[0, 0] == 2.0
    y.clear()
    for stamp in (now, now + 20):
        y.add(stamp, np.array([1.0]))
    assert align(y, u, now + S, ('hold',)) is None


def reconstruct(kind: str, times: Array, values: Array, at: Array) -> Array:
    """The input at times that are no sample times, from its samples."""
    if kind == 'linear':
        return np.asarray(np.interp(at, times, values))
    before = np.searchsorted(times, at) - 1
    if kind == 'hold':
        return np.asarray(values[before])
    after = np.minimum(before + 1, values.size - 1)
    return np.asarray(0.5 * (values[before] + values[after]))


@given(
    kind=st.sampled_from(['hold', 'linear', 'mean']),
    output_stamps=st.sets(st.integers(11, 80), min_size=2, max_size=15),
    input_stamps=st.sets(st.integers(0, 90), max_size=15),
    dropped=st.integers(0, 11),
    levels=st.booleans(),
)
def test_the_input_inside_a_record_needs_nothing_from_outside(
    kind: Interpolation,
    output_stamps: set[int],
    input_stamps: set[int],
    dropped: int,
    levels: bool,
) -> None:
    stamps = np.array(sorted({*input_stamps, 10, 95}))
    values = np.round(np.sin(stamps)) if levels else np.sin(stamps)
    inputs = dict(zip(stamps.tolist(), values.tolist(), strict=True))
    y, u = streams(dict.fromkeys(sorted(output_stamps), 1.0), inputs)
    u.drop_until(dropped * S)
    record = align(y, u, 80 * S, (kind,))
    assert record is not None
    assert (np.diff(record.t) > 0).all()
    known = ~np.isnan(record.u[:, 0])
    at = 0.5 * (record.t[:-1] + record.t[1:])
    np.testing.assert_allclose(
        reconstruct(kind, record.t[known], record.u[known, 0], at),
        reconstruct(kind, stamps, values, at),
        atol=1e-12,
    )
