"""Thinning keeps extremes, in bounded memory, whatever comes."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from obs_ros.pages.thinning import BLOCK, FACTOR, Thinned, ThinningSettings

SMALL = ThinningSettings(rows=BLOCK, levels=3)
HELD = BLOCK * FACTOR ** (SMALL.levels - 1)  # rows that the coarsest level holds at least
VALUES = st.one_of(st.floats(-1e6, 1e6), st.just(np.nan))
SPIKE = 1e9


def filled(rows, stamps=None, settings=SMALL):
    thinned = Thinned(rows.shape[1], settings)
    for stamp, row in zip(range(len(rows)) if stamps is None else stamps, rows):
        thinned.add(stamp, row)
    return thinned


def test_few_rows_stay_as_they_came():
    rows = np.array([[1.0, np.nan], [3.0, 2.0], [2.0, 5.0]])
    found = filled(rows).between(0, 10, 100)
    np.testing.assert_array_equal(found.low, rows)
    np.testing.assert_array_equal(found.high, rows)
    stamps, values = found.column(1)
    np.testing.assert_array_equal(stamps, [0, 1, 2])
    np.testing.assert_array_equal(values, [np.nan, 2.0, 5.0])


@given(
    seed=st.integers(0, 2**31),
    count=st.integers(1, HELD),
    most=st.integers(1, 200),
    part=st.tuples(st.floats(0, 1), st.floats(0, 1)),
    unmeasured=st.floats(0, 1),
)
def test_extremes_of_any_part_are_kept_at_their_stamps(seed, count, most, part, unmeasured):
    random = np.random.default_rng(seed)
    rows = random.standard_cauchy((count, 2))
    rows[random.random(rows.shape) < unmeasured] = np.nan
    begin, end = sorted(int(p * (count - 1)) for p in part)
    found = filled(rows).between(begin, end, most)
    assert len(found.low) <= most
    for place in range(2):
        inside = rows[begin : end + 1, place]
        stamps, values = found.column(place)
        known = np.isfinite(values)
        # Every point is one that came, and those of the part are between its extremes.
        np.testing.assert_array_equal(rows[stamps[known], place], values[known])
        assert (np.diff(stamps) >= 0).all()
        if np.isfinite(inside).any():
            assert np.nanmin(inside) >= values[known].min()
            assert np.nanmax(inside) <= values[known].max()
            shown = values[(stamps >= begin) & (stamps <= end)]
            # A bucket that reaches beyond may have a larger one there.
            beyond = values[(stamps < begin) | (stamps > end)]
            least, largest = np.nanmin(inside), np.nanmax(inside)
            assert least in shown or (beyond <= least).any()
            assert largest in shown or (beyond >= largest).any()


@settings(max_examples=30)
@given(place=st.integers(0, HELD - 1), low=st.booleans())
def test_one_spike_in_all_that_is_held_is_seen(place, low):
    rows = np.zeros((HELD, 1))
    rows[place] = -SPIKE if low else SPIKE
    stamps, values = filled(rows).between(0, HELD, 30).column(0)
    (spike,) = np.flatnonzero(np.abs(values) == SPIKE)
    assert stamps[spike] == place


@given(arrays(np.float64, st.tuples(st.integers(1, 100), st.just(1)), elements=VALUES))
def test_late_rows_are_kept_too(rows):
    late = np.random.default_rng(0).permutation(len(rows))
    stamps, values = filled(rows, late).between(0, len(rows), 1000).column(0)
    assert (np.diff(stamps) >= 0).all()
    np.testing.assert_array_equal(np.sort(values), np.sort(rows[:, 0]))


def test_memory_has_a_bound_and_the_newest_are_there():
    thinned = Thinned(1, SMALL)
    for k in range(6 * HELD):
        thinned.add(k, (float(k),))
    assert len(thinned) == 6 * HELD
    assert sum(level.size for level in thinned._levels) <= 2 * SMALL.rows * SMALL.levels
    assert sum(len(level._kept.low) for level in thinned._levels) <= 2 * SMALL.rows * SMALL.levels
    found = thinned.between(0, 6 * HELD, 10_000)
    assert found.high.max() == 6 * HELD - 1
    assert thinned.oldest == found.low_at.min() <= 5 * HELD
    stamps, rows = thinned.raw(0, 6 * HELD)
    assert len(stamps) >= SMALL.rows and stamps[-1] == 6 * HELD - 1
    np.testing.assert_array_equal(rows[:, 0], stamps)


@pytest.mark.parametrize(('back', 'begins'), [(99, False), (101, True)])
def test_a_stamp_far_back_is_of_a_new_timeline(back, begins):
    thinned = Thinned(1, SMALL)
    assert not thinned.goes_back(-5)
    for k in range(1000):
        thinned.add(10 * k, (0.0,))
    assert thinned.goes_back(9990 - 10 * back) is begins


def test_nothing_is_shown_of_nothing():
    thinned = Thinned(2)
    assert thinned.oldest is thinned.newest is None
    assert thinned.between(0, 10, 5).low.shape == (0, 2)
    assert len(thinned.raw(0, 10)[0]) == 0
    thinned.add(3, (1.0, 2.0))
    thinned.clear()
    assert len(thinned) == 0 and thinned.newest is None
