"""Tests of obs_ros.samples.window."""

import itertools
import random
from collections.abc import Callable, Iterable, Sequence

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from obs_ros.core.record import Record, Sample
from obs_ros.samples.align import align
from obs_ros.samples.window import COUNTS, SlidingWindow

NAN = np.nan
S = 10**9
MS = 10**6


def out(time: float, *values: float) -> Sample:
    """An output sample at a time in s; its value is the time unless given."""
    return Sample(round(time * S), y=np.array(values or (time,)))


def inp(time: float, *values: float) -> Sample:
    """An input sample at a time in s; its value is the time unless given."""
    return Sample(round(time * S), u=np.array(values or (time,)))


def feed(window: SlidingWindow, samples: Iterable[Sample]) -> list[Record]:
    """Push the samples and take every record as soon as there is one."""
    records = []
    for sample in samples:
        window.push(sample)
        records += take_all(window)
    return records


def take_all(window: SlidingWindow) -> list[Record]:
    return list(iter(window.take, None))


def counted(window: SlidingWindow) -> dict[str, int]:
    return {reason: count for reason, count in window.counts.items() if count}


def times(records: Sequence[Record]) -> list[list[float]]:
    return [record.t.round(6).tolist() for record in records]


def outputs_only(
    duration: float = 10.0, period: float | None = None, capacity: int = 20000
) -> SlidingWindow:
    return SlidingWindow(duration, period, n_inputs=0, n_outputs=1, capacity=capacity)


def both(
    duration: float = 10.0, period: float | None = None, capacity: int = 20000
) -> SlidingWindow:
    return SlidingWindow(duration, period, n_inputs=1, n_outputs=1, capacity=capacity)


class TestConstruction:
    @pytest.mark.parametrize('duration', [0.0, -1.0, NAN, np.inf, 1e-10, 3e9])
    def test_duration_and_period_must_be_positive_times(self, duration: float) -> None:
        with pytest.raises(ValueError, match=f'duration {duration} s'):
            outputs_only(duration)
        with pytest.raises(ValueError, match=f'period {duration} s'):
            outputs_only(1.0, duration)

    def test_capacity_and_sizes_must_make_sense(self) -> None:
        with pytest.raises(ValueError, match='capacity 1 is too small'):
            outputs_only(capacity=1)
        with pytest.raises(ValueError, match='0 inputs and 0 outputs'):
            SlidingWindow(1.0, n_inputs=0, n_outputs=0)
        with pytest.raises(ValueError, match='-1 inputs'):
            SlidingWindow(1.0, n_inputs=-1, n_outputs=1)

    def test_one_known_interpolation_per_input(self) -> None:
        with pytest.raises(ValueError, match='1 interpolations given for 2 inputs'):
            SlidingWindow(1.0, n_inputs=2, n_outputs=1, interpolation=['hold'])
        with pytest.raises(ValueError, match="'cubic' is none of hold, linear, mean"):
            SlidingWindow(1.0, n_inputs=1, n_outputs=1, interpolation=['cubic'])  # type: ignore[list-item]


class TestWindows:
    def test_abutting_windows_use_each_output_once_and_the_first_includes_its_start(self) -> None:
        records = feed(outputs_only(2.0), (out(t) for t in np.arange(5.0, 12.0)))
        assert times(records) == [[5, 6, 7], [8, 9], [10, 11]]
        assert [record.stamp for record in records] == [7 * S, 9 * S, 11 * S]

    def test_overlapping_windows(self) -> None:
        records = feed(outputs_only(3.0, 1.0), (out(t) for t in np.arange(6.0)))
        assert times(records) == [[0, 1, 2, 3], [2, 3, 4], [3, 4, 5]]

    def test_windows_with_gaps_between_them(self) -> None:
        records = feed(outputs_only(2.0, 4.0), (out(t) for t in np.arange(12.0)))
        assert times(records) == [[0, 1, 2], [5, 6], [9, 10]]

    def test_window_waits_for_the_slower_stream(self) -> None:
        window = both(2.0)
        assert feed(window, [inp(0.0), out(0.0), out(1.0), out(2.0), out(3.0), inp(1.9)]) == []
        assert window.end == 2 * S
        assert times(feed(window, [inp(2.0)])) == [[0, 1, 1.9, 2]]
        assert window.end == 4 * S
        assert feed(window, [inp(6.0), out(3.9)]) == []
        assert len(feed(window, [out(4.0)])) == 1

    def test_what_is_collected_is_what_both_streams_have_reached(self) -> None:
        window = both()
        assert (window.collected, window.end) == (None, None)
        feed(window, [inp(1.0), out(2.0), out(1.5)])
        assert (window.collected, window.end) == (0.0, 11_500_000_000)
        feed(window, [inp(4.0)])
        assert window.collected == pytest.approx(0.5)

    def test_first_window_starts_when_every_input_has_a_value(self) -> None:
        window = SlidingWindow(2.0, n_inputs=2, n_outputs=1)
        samples = [out(0.0), inp(0.5, 1.0, NAN), out(1.0), inp(1.5, NAN, 2.0)]
        samples += [out(t) for t in (2.0, 3.0, 4.0)] + [inp(4.0, 3.0, 3.0)]
        (record,) = feed(window, samples)
        assert record.t.tolist() == [2.0, 3.0, 4.0]
        np.testing.assert_array_equal(record.u, [[1, 2], [NAN, NAN], [3, 3]])
        assert counted(window) == {'before_input': 2, 'nan': 2}

    def test_an_input_at_the_very_stamp_of_the_first_output_is_in_time(self) -> None:
        window = both(1.0)
        (record,) = feed(window, [out(1.0), out(2.0), inp(1.0, 7.0), inp(2.0, 8.0)])
        assert record.u[:, 0].tolist() == [7.0, 8.0]
        assert counted(window) == {}

    def test_one_sample_may_carry_outputs_and_inputs(self) -> None:
        samples = [Sample(k * S, y=np.array([k]), u=np.array([-k])) for k in range(3)]
        (record,) = feed(both(2.0), samples)
        np.testing.assert_array_equal(record.y, -record.u)

    def test_single_outputs_make_no_record(self) -> None:
        window = outputs_only(1.0)
        records = feed(window, [out(t) for t in (0.0, 0.5, 1.5, 3.0, 3.5, 4.0)])
        assert times(records) == [[0, 0.5], [3.5, 4.0]]
        assert counted(window) == {'too_few': 2}

    def test_wrong_sizes_are_refused_and_nothing_is_stored(self) -> None:
        window = SlidingWindow(1.0, n_inputs=2, n_outputs=1)
        with pytest.raises(ValueError, match=r'outputs of shape \(3,\), not \(1,\)'):
            window.push(out(0.0, 1.0, 2.0, 3.0))
        with pytest.raises(ValueError, match=r'inputs of shape \(1,\), not \(2,\)'):
            window.push(Sample(0, y=np.zeros(1), u=np.zeros(1)))
        feed(window, [inp(0.0, 1.0, 1.0)])
        assert window.end is None

    def test_values_are_copied(self) -> None:
        window, y = outputs_only(1.0), np.array([5.0])
        window.push(Sample(0, y=y))
        y[0] = 6.0
        (record,) = feed(window, [out(1.0)])
        assert record.y[0, 0] == 5.0

    def test_time_is_the_stamp_in_seconds(self) -> None:
        now = 1_760_000_000_123_456_789
        (record,) = feed(outputs_only(1.0), [Sample(now + k * S, y=np.ones(1)) for k in (0, 1)])
        np.testing.assert_allclose(record.t, [1760000000.1234568, 1760000001.1234568], rtol=1e-15)
        assert record.stamp == now + S

    def test_linear_input_is_interpolated_at_the_first_node(self) -> None:
        window = SlidingWindow(2.0, n_inputs=1, n_outputs=1, interpolation=['linear'])
        samples = [inp(0.0, 0.0), out(1.0), inp(2.0, 10.0), out(3.0), inp(4.0, 40.0)]
        (record,) = feed(window, samples)
        np.testing.assert_array_equal(record.u[:, 0], [5, 10, 25])


class TestInputsBetweenOutputs:
    def test_last_value_before_the_first_node_is_held(self) -> None:
        window = both(2.0)
        first = [inp(0.0, 1.0), inp(0.5, 2.0), out(1.0), out(2.0), inp(2.5, 3.0), out(3.0)]
        (record,) = feed(window, [*first, inp(3.2, 4.0)])
        assert record.t.tolist() == [1.0, 2.0, 2.5, 3.0]
        np.testing.assert_array_equal(record.u[:, 0], [2, NAN, 3, NAN])
        np.testing.assert_array_equal(record.y[:, 0], [1, 2, NAN, 3])
        # The value before the next window's first output, from inside that window.
        (record,) = feed(window, [out(4.0), inp(4.5, 5.0), out(5.0), inp(5.0, 6.0)])
        assert record.t.tolist() == [4.0, 4.5, 5.0]
        assert record.u[:, 0].tolist() == [4.0, 5.0, 6.0]

    def test_an_input_from_long_ago_still_holds(self) -> None:
        window = both(2.0)
        assert feed(window, [inp(0.0, 9.0), *(out(t) for t in np.arange(0.0, 41.0))]) == []
        records = feed(window, [inp(40.0, 8.0)])
        assert len(records) == 20
        assert [record.u[0, 0] for record in records] == [9.0] * 20
        assert counted(window) == {}

    def test_inputs_rarer_than_windows_are_no_break(self) -> None:
        window = both(1.0)
        samples = sorted([out(t / 2) for t in range(121)] + [inp(t) for t in range(0, 61, 10)],
                         key=lambda sample: sample.stamp)  # fmt: skip
        records = feed(window, samples)
        assert len(records) == 60
        assert counted(window) == {}
        assert records[15].u[0, 0] == 10.0

    def test_a_partly_nan_input_holds_its_old_entries(self) -> None:
        window = SlidingWindow(1.0, n_inputs=2, n_outputs=1)
        samples = [inp(0.0, 1.0, 2.0), out(0.0), out(1.0), inp(1.0, np.inf, 3.0)]
        samples += [inp(1.2, 9.0, NAN), out(1.5), out(2.0), inp(2.0, NAN, NAN), inp(2.1, 0.0, 0.0)]
        window.push(out(-1.0))
        first, second = feed(window, samples)
        np.testing.assert_array_equal(first.u, [[1, 2], [NAN, 3]])
        np.testing.assert_array_equal(second.u, [[9, 3], [NAN, NAN]])
        assert counted(window) == {'nan': 2, 'all_nan': 1, 'before_input': 1}


class TestNewest:
    """Straight to the newest window, whatever the settings: a remote one must not block a node."""

    @given(
        st.integers(1, 40),
        st.integers(1, 40),
        st.lists(st.integers(0, 120), min_size=1, max_size=40, unique=True).map(sorted),
        st.lists(st.integers(0, 120), min_size=1, max_size=40, unique=True).map(sorted),
    )
    @settings(max_examples=300)
    def test_it_is_the_last_of_those_taken_one_by_one(self, duration, period, outputs, inputs):  # type: ignore[no-untyped-def]
        all_of_them, newest = (both(float(duration), float(period)) for _ in range(2))
        samples = [*map(inp, inputs), *map(out, outputs)]
        for sample in samples:
            all_of_them.push(sample)
            newest.push(sample)
        records, last = take_all(all_of_them), newest.take_newest()
        assert (last is None) == (not records)
        if last is not None:
            assert last.t.tolist() == records[-1].t.tolist()
            np.testing.assert_array_equal(last.u, records[-1].u)
        assert newest.take_newest() is None
        assert newest.counts['skipped'] == max(0, len(records) - 1)
        assert newest.counts['too_few'] == all_of_them.counts['too_few']
        assert newest.end == all_of_them.end

    @pytest.mark.parametrize(('duration', 'period'), [(300.0, 1e-9), (1e-9, 1e-9), (1e-5, 300.0)])
    @pytest.mark.parametrize('take', ['take', 'take_newest'])
    def test_no_settings_make_a_sample_cost_more_than_a_window(
        self, monkeypatch: pytest.MonkeyPatch, take: str, duration: float, period: float
    ) -> None:
        """A period of 1 ns closes 10^9 windows a second: at most one of them is looked at."""
        built = 0

        def counting(*arguments: object) -> Record | None:
            nonlocal built
            built += 1
            return align(*arguments)  # type: ignore[arg-type]

        monkeypatch.setattr('obs_ros.samples.window.align', counting)
        window = outputs_only(duration, period)
        for t in range(1000):
            window.push(out(t))
            before = built
            getattr(window, take)()
            assert built - before <= 1
        passed = window.counts['skipped'] + window.counts['too_few'] + built
        if take == 'take_newest' and duration > 1.0:
            assert passed == (999 - 300) * 10**9 + 1


class TestLateAndBrokenSamples:
    def test_late_samples_of_the_open_window_are_sorted_in_older_ones_dropped(self) -> None:
        window = outputs_only(2.0)
        samples = [out(t) for t in (0.0, 1.5, 1.0, 2.0, 3.5, 2.5, 1.7, 4.0)]
        assert times(feed(window, samples)) == [[0, 1, 1.5, 2], [2.5, 3.5, 4.0]]
        assert counted(window) == {'reordered': 2, 'late': 1}

    def test_a_late_first_output_moves_the_start(self) -> None:
        window = outputs_only(2.0)
        assert times(feed(window, [out(1.0), out(0.0), out(2.0)])) == [[0, 1, 2]]

    def test_a_window_not_taken_yet_still_accepts_late_samples(self) -> None:
        window = outputs_only(2.0)
        for time in (0.0, 1.0, 2.0, 3.0, 1.5):
            window.push(out(time))
        assert times(feed(window, [out(3.5)])) == [[0, 1, 1.5, 2]]

    def test_a_late_input_is_the_value_at_the_start_if_it_is_the_last_before_it(self) -> None:
        window = both(2.0)
        feed(window, [inp(0.0, 1.0), out(0.0), out(2.0), inp(3.0, 5.0)])
        feed(window, [inp(1.9, 4.0), inp(1.8, 3.0)])
        (record,) = feed(window, [out(2.5), out(4.0), inp(4.0, 6.0)])
        np.testing.assert_array_equal(record.u[:, 0], [4, 5, 6])
        assert counted(window) == {'late': 2}

    def test_of_equal_stamps_the_first_counts(self) -> None:
        window = both(2.0)
        samples = [inp(0.0, 1.0), inp(0.0, 2.0), out(0.0, 3.0), out(1.0), out(0.0, 4.0), out(2.0)]
        (record,) = feed(window, [*samples, inp(2.0)])
        assert record.u[0, 0] == 1.0
        assert record.y[0, 0] == 3.0
        assert counted(window) == {'duplicate': 2}

    def test_samples_at_the_end_of_a_window_already_taken(self) -> None:
        window = outputs_only(2.0)
        feed(window, [out(t) for t in (0.0, 1.0, 2.0, 2.0, 2.5, 2.0)])
        assert counted(window) == {'duplicate': 1, 'late': 1}

    def test_a_window_that_inputs_have_not_passed_waits_for_late_outputs(self) -> None:
        window = both(1.0)
        feed(window, [inp(0.0), out(0.0), out(1.0), out(2.6), inp(1.0)])
        assert window.end == 2 * S
        assert times(feed(window, [out(1.5), out(2.0), inp(2.0)])) == [[1.5, 2.0]]
        assert counted(window) == {'reordered': 2}

    def test_nan_and_infinite_outputs(self) -> None:
        window = SlidingWindow(3.0, n_inputs=0, n_outputs=2)
        samples = [out(0.0, 1.0, NAN), out(1.0, NAN, NAN), out(2.0, -np.inf, 2.0), out(3.0, 1.0, 2)]
        (record,) = feed(window, [*samples[:3], out(2.5, np.inf, -np.inf), samples[3]])
        assert record.t.tolist() == [0.0, 2.0, 3.0]
        np.testing.assert_array_equal(record.y, [[1, NAN], [NAN, 2], [1, 2]])
        assert counted(window) == {'nan': 2, 'all_nan': 2}

    def test_values_whose_squares_are_numbers_are_measured(self) -> None:
        window = SlidingWindow(1.0, n_inputs=0, n_outputs=2)
        (record,) = feed(window, [out(0.0, 1e99, 1e99), out(1.0, 0.0, 0.0)])
        assert record.y[0].tolist() == [1e99, 1e99]
        assert counted(window) == {}

    def test_stamps_no_clock_can_give(self) -> None:
        window = outputs_only()
        for stamp in (2**62, -(2**62), 2**63, -(2**80)):
            window.push(Sample(stamp, y=np.ones(1)))
        assert counted(window) == {'out_of_range': 4}
        assert window.end is None


class TestResumed:
    """A window that goes on after the last one of an earlier process."""

    @pytest.mark.parametrize(('duration', 'period'), [(10.0, None), (10.0, 4.0), (4.0, 10.0)])
    @pytest.mark.parametrize('gap', [0.0, 7.0, 13.0])
    def test_it_has_the_windows_that_the_earlier_one_would_have_had(
        self, duration: float, period: float | None, gap: float
    ) -> None:
        rng = random.Random(1)
        stamps = sorted({round(rng.uniform(0.0, 80.0), 2) for _ in range(200)})
        stamps = [t + (gap if t > 40.0 else 0.0) for t in stamps]
        stream = [s for t in stamps for s in (inp(t), out(t + 0.001))]
        whole = both(duration, period)
        ends, records = [], []
        for sample in stream:
            whole.push(sample)
            while (record := whole.take()) is not None:
                records.append(record)
                ends.append(whole.last_end)
        assert len(records) > 6
        for k, end in enumerate(ends[:-1]):
            assert end is not None
            step = duration if period is None else period
            left = end + round((step - duration) * S)
            resumed = both(duration, period)
            resumed.resume(end)
            # The input in force there comes first, as a latched one does.
            held = max(s.stamp for s in stream if s.u is not None and s.stamp <= left)
            again = [s for s in stream if s.stamp > left or (s.u is not None and s.stamp == held)]
            found = feed(resumed, again)
            assert len(found) == len(records) - k - 1
            for one, other in zip(found, records[k + 1 :], strict=True):
                for name in ('t', 'u', 'y'):
                    np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
            assert not counted(resumed).keys() & {'late', 'reset', 'ahead', 'before_input'}

    def test_outputs_that_come_before_the_first_input_are_counted_as_what_they_are(self) -> None:
        window = both(10.0, None)
        window.resume(30 * S)
        early = [out(31.0 + k) for k in range(6)]
        records = feed(window, [*early, *(s for t in range(37, 62) for s in (inp(t), out(t)))])
        assert [(r.t[0], r.t[-1]) for r in records] == [(37.0, 40.0), (41.0, 50.0), (51.0, 60.0)]
        assert counted(window) == {'before_input': 6}

    def test_so_are_those_that_no_memory_holds_until_then(self) -> None:
        window = SlidingWindow(10.0, n_inputs=1, n_outputs=1, capacity=50)
        window.resume(30 * S)
        assert feed(window, [out(31.0 + k) for k in range(80)]) == []
        assert counted(window) == {'before_input': 30}

    def test_a_clock_that_was_set_back_begins_a_new_timeline(self) -> None:
        window = outputs_only()
        window.resume(1000 * S)
        assert [window.push(out(float(t))) for t in range(5)] == [False] * 4 + [True]
        assert feed(window, [out(float(t)) for t in range(5, 12)])[0].t[0] == 0.0


class TestBreaks:
    @pytest.mark.parametrize('stray', [0.0, 2400.0, 2500.0 + 365 * 86400])
    @pytest.mark.parametrize('make', [out, inp])
    def test_a_stray_stamp_leaves_the_records_as_they_are(
        self, make: Callable[[float], Sample], stray: float
    ) -> None:
        def run(strays: list[Sample]) -> tuple[list[Record], SlidingWindow]:
            window = both(2.0)
            stamps = [2500.0 + t for t in range(8)]
            records = []
            for k, time in enumerate(stamps):
                records += feed(window, [inp(time), out(time), *(strays if k in (1, 4) else [])])
            return records, window

        clean, _ = run([])
        records, window = run([make(stray)])
        assert times(records) == times(clean)
        assert len(records) == 3
        for record, expected in zip(records, clean, strict=True):
            np.testing.assert_array_equal(record.u, expected.u)
            np.testing.assert_array_equal(record.y, expected.y)
        assert counted(window) == {'ahead' if stray > 2500.0 else 'late': 2}
        assert window.last_break is None

    def test_five_rising_old_stamps_start_a_new_timeline_and_none_is_lost(self) -> None:
        window = outputs_only(2.0)
        feed(window, [out(2490.0 + t) for t in range(11)])
        assert feed(window, [out(t, 10 + t) for t in range(4)]) == []
        assert window.counts['reset'] == 0
        records = feed(window, [out(4.0)])
        assert window.last_break == (
            'output stamps jumped back from 2500.0 s to 0.0 s: all samples forgotten'
        )
        assert times(records) == [[0, 1, 2], [3, 4]]
        assert records[0].y[:, 0].tolist() == [10.0, 11.0, 12.0]
        assert window.counts['reset'] == 1

    def test_four_are_not_enough_and_a_sample_in_order_clears_the_suspicion(self) -> None:
        window = outputs_only(2.0)
        feed(window, [out(100.0)])
        for newest in range(101, 120):
            feed(window, [*(out(t) for t in range(4)), out(newest)])
        assert window.counts['reset'] == 0
        assert window.counts['late'] == 19 * 4

    def test_a_jump_inside_the_open_window_does_not_mix_timelines(self) -> None:
        window = outputs_only(20.0)
        feed(window, [out(t, 1.0) for t in range(10)])
        records = feed(window, [out(t + 0.5, 2.0) for t in range(25)])
        assert window.counts['reset'] == 1
        (record,) = records
        np.testing.assert_array_equal(record.y[:, 0], 2.0)
        assert record.t[0] == 0.5

    def test_a_looping_recording_shorter_than_the_window_repeats_every_stamp(self) -> None:
        window = outputs_only(20.0)
        feed(window, [out(t, 1.0) for t in range(10)] + [out(t, 2.0) for t in range(10)])
        assert window.counts['duplicate'] == 5
        assert window.counts['reset'] == 1
        assert (window.collected, window.end) == (pytest.approx(9.0), 20 * S)

    def test_a_gap_longer_than_the_window_starts_it_afresh(self) -> None:
        window = outputs_only(2.0)
        feed(window, [out(t) for t in range(4)])
        records = feed(window, [out(100.3 + t) for t in range(6)])
        assert times(records) == [[100.3, 101.3, 102.3], [103.3, 104.3]]
        assert window.last_break is not None
        assert 'ahead from 3.0 s to 100.3 s' in window.last_break
        assert counted(window) == {'reset': 1}

    def test_a_gap_of_a_window_and_a_period_is_no_break(self) -> None:
        window = outputs_only(2.0)
        records = feed(window, [out(t) for t in (0.0, 1.0, 2.0, 6.0, 7.0, 8.0)])
        assert times(records) == [[0, 1, 2], [7, 8]]
        assert counted(window) == {'too_few': 2}

    @pytest.mark.parametrize('sent', [0.0, 7.0])
    def test_one_stamp_for_ever_never_resets(self, sent: float) -> None:
        window = outputs_only(2.0)
        feed(window, [out(10.0), *(out(sent) for _ in range(100))])
        assert window.counts['reset'] == 0
        window = outputs_only(2.0)
        feed(window, [out(sent) for _ in range(100)])
        assert counted(window) == {'duplicate': 99}

    @pytest.mark.parametrize('jump', [-2000.0, 2000.0])
    @pytest.mark.parametrize('lag', range(-8, 9))
    def test_streams_that_jump_one_after_the_other_heal(self, jump: float, lag: int) -> None:
        window = both(2.0)
        feed(window, [sample(2500.0 + t) for t in range(6) for sample in (inp, out)])
        outputs = [out(t) for t in np.arange(2506.0, 2506.0 + max(lag, 0))]
        inputs = [inp(t) for t in np.arange(2506.0, 2506.0 + max(-lag, 0))]
        outputs += [out(2506.0 + jump + t) for t in range(60)]
        inputs += [inp(2506.0 + jump + t) for t in range(60)]
        records = feed(window, (s for pair in zip(outputs, inputs, strict=False) for s in pair))
        assert 1 <= window.counts['reset'] <= 3
        late = [record for record in records if abs(record.t[0] - 2530.0 - jump) < 20.0]
        assert len(late) >= 9
        for record in late:
            np.testing.assert_allclose(record.y[:, 0], record.t, rtol=1e-12)
            np.testing.assert_allclose(record.u[:, 0], record.t, rtol=1e-12)

    def test_samples_with_both_streams_lose_nothing_in_a_jump(self) -> None:
        window = both(2.0)
        feed(window, [Sample((500 + t) * S, y=np.ones(1), u=np.ones(1)) for t in range(8)])
        records = feed(window, [Sample(t * S, y=np.ones(1), u=np.ones(1)) for t in range(8)])
        assert times(records) == [[0, 1, 2], [3, 4], [5, 6]]
        assert window.counts['reset'] == 1

    def test_reset_forgets_samples_but_not_counts(self) -> None:
        window = outputs_only(2.0)
        feed(window, [out(0.0), out(0.0), out(1.0), out(1000.0)])
        window.reset()
        assert counted(window) == {'duplicate': 1, 'ahead': 1}
        assert (window.collected, window.end, window.take()) == (None, None, None)
        assert times(feed(window, [out(t) for t in (1.0, 2.0, 3.0)])) == [[1, 2, 3]]

    def test_counts_are_a_copy_with_every_reason(self) -> None:
        window = outputs_only()
        counts = window.counts
        assert set(counts) == set(COUNTS)
        counts['late'] = 7  # type: ignore[index]
        assert window.counts['late'] == 0


class TestCapacity:
    def test_a_window_larger_than_the_capacity_loses_its_oldest_samples(self) -> None:
        window = outputs_only(10.0, capacity=4)
        records = feed(window, [out(t) for t in range(21)])
        assert times(records) == [[7, 8, 9, 10], [17, 18, 19, 20]]
        assert counted(window) == {'overflow': 13}

    def test_the_last_dropped_input_still_holds(self) -> None:
        window = both(10.0, capacity=2)
        samples = [inp(t) for t in (0.0, 1.0, 2.0, 6.0, 10.0)] + [out(t) for t in (0.0, 4.0, 10.0)]
        (record,) = feed(window, sorted(samples, key=lambda sample: sample.stamp))
        assert record.t.tolist() == [4.0, 6.0, 10.0]
        assert record.u[:, 0].tolist() == [2.0, 6.0, 10.0]
        assert counted(window) == {'overflow': 4}

    def test_outputs_whose_inputs_were_dropped_are_dropped_too(self) -> None:
        window = both(10.0, capacity=3)
        samples = [inp(t) for t in (0.0, 5.0, 6.0, 8.0, 10.0)] + [out(t) for t in (0.0, 7.0, 10.0)]
        (record,) = feed(window, sorted(samples, key=lambda sample: sample.stamp))
        assert record.t.tolist() == [7.0, 8.0, 10.0]
        assert record.u[:, 0].tolist() == [6.0, 8.0, 10.0]
        assert counted(window) == {'overflow': 3}

    def test_outputs_without_inputs_are_dropped_for_ever(self) -> None:
        window = both(1.0, capacity=10)
        feed(window, [out(t) for t in range(0, 100)])
        assert counted(window) == {'before_input': 90}

    def test_windows_that_nobody_took_are_skipped_at_once(self) -> None:
        window = outputs_only(1.5, 0.001, capacity=10)
        for second in range(2_000):
            window.push(out(second))
        record = window.take()
        assert record is not None
        assert record.t.tolist() == [1990.0, 1991.0]
        # Window k ends at 1.5 + k / 1000 s; this is the first to reach the output at 1991 s.
        assert window.counts['too_few'] == 1_989_500


def test_samples_without_end_leave_the_memory_flat() -> None:
    """200 times as many as the window holds."""
    window = SlidingWindow(0.1, n_inputs=2, n_outputs=2, capacity=500)
    values, records = np.ones(2), 0
    sizes = set()
    for k in range(100_000):
        window.push(Sample(k * MS, y=values, u=values))
        if k % 250 == 249:
            records += len(take_all(window))
            if k > 10_000:
                sizes.add(window.nbytes)
    assert records == 999
    assert len(sizes) == 1
    for k in range(100_000, 110_000):
        window.push(Sample(k * MS, y=values, u=values))
    assert window.nbytes == 2 * (2 * 500 + 2) * 3 * 8


# Properties. Times are small integers in ms, so that equal and neighbouring stamps are common.


def stamps_with_gaps(largest: int) -> st.SearchStrategy[list[int]]:
    gaps = st.lists(st.integers(1, largest), min_size=1, max_size=60)
    return st.builds(
        lambda start, gaps: list(itertools.accumulate(gaps, initial=start)),
        st.integers(0, 20),
        gaps,
    )


def samples_of(output_stamps: Iterable[int], input_stamps: Iterable[int]) -> list[Sample]:
    """Samples in stamp order, inputs first; every value is unique."""
    samples = [Sample(k * MS, u=np.array([1000.0 + k])) for k in input_stamps]
    samples += [Sample(k * MS, y=np.array([float(k)])) for k in output_stamps]
    return sorted(samples, key=lambda sample: sample.stamp)


def reference(
    output_stamps: list[int], input_stamps: list[int], duration: int, period: int
) -> list[dict[int, tuple[float, float]]]:
    """All records as {stamp in ms: (y, u)}, from the complete lists and the rules alone."""
    start = next((k for k in output_stamps if input_stamps and k >= input_stamps[0]), None)
    records: list[dict[int, tuple[float, float]]] = []
    if start is None:
        return records
    last_left = min(output_stamps[-1], input_stamps[-1]) - duration
    for left in range(start, last_left + 1, period):
        inside = [k for k in output_stamps if left + (left > start) <= k <= left + duration]
        if len(inside) < 2:
            continue
        nodes = {k for k in input_stamps if inside[0] <= k <= inside[-1]} | set(inside)
        held = 1000.0 + max(k for k in input_stamps if k <= inside[0])
        record = {
            k: (float(k) if k in inside else NAN, 1000.0 + k if k in input_stamps else NAN)
            for k in sorted(nodes)
        }
        record[inside[0]] = (float(inside[0]), held)
        records.append(record)
    return records


def assert_same(records: list[Record], expected: list[dict[int, tuple[float, float]]]) -> None:
    assert len(records) == len(expected)
    for record, nodes in zip(records, expected, strict=True):
        np.testing.assert_allclose(record.t, np.array(list(nodes)) * 1e-3, rtol=1e-12)
        np.testing.assert_array_equal(np.hstack([record.y, record.u]), list(nodes.values()))
        assert (np.diff(record.t) > 0).all()


@settings(max_examples=300)
@given(stamps_with_gaps(20), stamps_with_gaps(20), st.integers(20, 150), st.integers(5, 150))
def test_records_are_those_of_the_rules(
    output_stamps: list[int], input_stamps: list[int], duration: int, period: int
) -> None:
    window = both(duration * 1e-3, period * 1e-3)
    records = feed(window, samples_of(output_stamps, input_stamps))
    assert_same(records, reference(output_stamps, input_stamps, duration, period))


# Five gaps of 10 ms are less than the shortest window: no sample of a block comes too late.
@settings(max_examples=300)
@given(
    stamps_with_gaps(10),
    stamps_with_gaps(10),
    st.integers(50, 150),
    st.integers(5, 150),
    st.randoms(use_true_random=False),
)
def test_late_samples_make_no_difference(
    output_stamps: list[int],
    input_stamps: list[int],
    duration: int,
    period: int,
    random: random.Random,
) -> None:
    window = both(duration * 1e-3, period * 1e-3)
    records = []
    samples = samples_of(output_stamps, input_stamps)
    # Of five samples at most four come late in a row: one fewer than tell of a new timeline.
    for first in range(0, len(samples), 5):
        block = samples[first : first + 5]
        random.shuffle(block)
        for sample in block:
            window.push(sample)
        records += take_all(window)
    assert_same(records, reference(output_stamps, input_stamps, duration, period))


@settings(max_examples=300)
@given(
    stamps_with_gaps(20),
    stamps_with_gaps(20),
    st.integers(20, 150),
    st.integers(5, 150),
    st.integers(2, 10),
)
def test_overflow_shortens_records_but_never_falsifies_them(
    output_stamps: list[int], input_stamps: list[int], duration: int, period: int, capacity: int
) -> None:
    window = both(duration * 1e-3, period * 1e-3, capacity=capacity)
    for record in feed(window, samples_of(output_stamps, input_stamps)):
        stamps = [round(t * 1e3) for t in record.t]
        y, u = ([None if np.isnan(v) else v for v in a[:, 0]] for a in (record.y, record.u))
        held = max(k for k in input_stamps if k <= stamps[0])
        assert u == [
            1000.0 + held,
            *(1000.0 + k if k in input_stamps else None for k in stamps[1:]),
        ]
        assert y == [float(k) if k in output_stamps else None for k in stamps]
        between = {k for k in (*output_stamps, *input_stamps) if stamps[0] <= k <= stamps[-1]}
        assert set(stamps) == between


@given(stamps_with_gaps(20), st.integers(10, 300))
def test_abutting_windows_use_every_output_of_a_window_exactly_once(
    stamps: list[int], duration: int
) -> None:
    window = outputs_only(duration * 1e-3)
    records = feed(window, samples_of(stamps, []))
    used = [value for record in records for value in record.y[:, 0].tolist()]
    assert used == sorted(set(used))
    # Only windows with a single output, and the one still open, leave outputs out.
    passed = stamps[0] + (stamps[-1] - stamps[0]) // duration * duration
    closed = [float(k) for k in stamps if k <= passed and passed > stamps[0]]
    assert set(used) <= set(closed)
    assert len(closed) - len(used) <= window.counts['too_few']
    if not window.counts['too_few']:
        assert used == closed


garbage = st.one_of(
    st.integers(-50, 50).map(lambda k: k * S),
    st.integers(-(2**70), 2**70),
    st.sampled_from([0, 10 * S, 2**62 - 1, 1 - 2**62, 2**63, -(2**63)]),
)
garbage_values = st.sampled_from([0.0, 1.0, NAN, np.inf, -np.inf, 1e308])


@settings(max_examples=300)
@given(
    st.lists(st.tuples(st.booleans(), garbage, garbage_values, garbage_values), max_size=200),
    st.integers(2, 20),
    st.sampled_from([1.0, 7.0, 2e9]),
    st.sampled_from([None, 1.0, 3.0]),
)
def test_garbage_never_raises_and_memory_is_bounded(
    samples: list[tuple[bool, int, float, float]],
    capacity: int,
    duration: float,
    period: float | None,
) -> None:
    window = SlidingWindow(
        duration,
        period,
        n_inputs=2,
        n_outputs=2,
        capacity=capacity,
        interpolation=['linear', 'mean'],
    )
    for is_output, stamp, a, b in samples:
        values = np.array([a, b])
        sample = Sample(stamp, y=values) if is_output else Sample(stamp, u=values)
        for record in feed(window, [sample]):
            assert (np.diff(record.t) > 0).all()
            assert not np.isnan(record.u[0]).any()
            assert record.t.size <= 2 * capacity
        assert window.nbytes <= 2 * (2 * capacity + 2) * 3 * 8


@pytest.mark.parametrize('drift', [0.0, 2e-4, -2e-4])
def test_windows_of_a_discrete_model_have_as_many_nodes_whatever_the_clock(drift: float) -> None:
    """Nodes every 0.1 s, outputs at each second one, inputs that follow them, with jitter."""
    rng, window = random.Random(1), SlidingWindow(2.0, n_inputs=1, n_outputs=1, nodes=0.1)
    records = []
    for k in range(2000):
        at = 0.1 * k * (1.0 + drift)
        samples = [inp(at + rng.uniform(0.0, 0.002), float(k))]
        if k % 2 == 0:
            samples.insert(0, out(at + rng.uniform(-0.004, 0.004), float(k)))
        records += feed(window, samples)
    assert counted(window) == {}
    assert len(records) == 99
    assert [record.t.size for record in records] == [21, *[19] * 98]
    for record in records:
        np.testing.assert_array_equal(
            record.u[:-1, 0], record.y[0, 0] + np.arange(len(record.t) - 1)
        )
        np.testing.assert_array_equal(
            record.y[::2, 0], record.y[0, 0] + np.arange(0, len(record.t), 2)
        )
        assert np.isnan(record.y[1::2]).all()
        np.testing.assert_allclose(np.diff(record.t), 0.1, rtol=0.1)
