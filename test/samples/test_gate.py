"""Tests of obs_ros.samples.gate: one set of rules, whoever takes the samples."""

from dataclasses import dataclass, field, replace
from typing import Any, Literal

import numpy as np
import pytest
from plants import VESSEL

from obs_ros import Estimate, Outcome, Sample
from obs_ros.core.typing import Array
from obs_ros.horizon.prediction import Prediction
from obs_ros.interface.parameters import COMMON
from obs_ros.models.three_tank import THREE_TANK
from obs_ros.observers.output_intake import Instant
from obs_ros.observers.recursive import RecursiveObserver
from obs_ros.replay.forecast import Forecaster
from obs_ros.samples.gate import COUNTS, Gate, GateSettings
from obs_ros.samples.window import SlidingWindow

S = 10**9
NAN, INF = float('nan'), float('inf')
Event = tuple[Literal['u', 'y'], float, float]  # stream, time (s), value


def sample(event: Event) -> Sample:
    kind, t, value = event
    return Sample(round(t * S), **{kind: np.array([value])})


def run(first: float, count: int) -> list[Event]:
    """Inputs and outputs, 100 a second, from a time on."""
    return [(kind, first + 0.01 * k, 1.0) for k in range(count) for kind in ('u', 'y')]


class Stepping(RecursiveObserver):
    """Steps from output to output, and does nothing else."""

    def _start(self, now: Instant) -> None:
        self.innovation[:] = 0.0

    def _step(self, before: Instant, now: Instant, path: Any) -> None:
        self.innovation[:] = 0.0


START, LEAD, DURATION = 10_000.0, 20, 1000.0  # s, samples, s
LAST = START + 0.01 * (LEAD - 1)
AFTER = run(LAST + 0.01, 8)


@dataclass(frozen=True)
class Stream:
    """Events after `lead`; counts that all give alike.

    `old` samples are not the newest of their stream: sorted in by whoever can go back, else late.
    """

    events: list[Event]
    counts: dict[str, int] = field(default_factory=dict)
    old: int = 0
    lead: list[Event] = field(default_factory=lambda: run(START, LEAD))

    @property
    def breaks(self) -> bool:
        return bool(self.counts.get('reset'))


STREAMS = {
    'in order': Stream(AFTER),
    'a gap of 15 s': Stream(run(LAST + 15.0, 8)),
    'a late output and then a gap': Stream(
        [('y', LAST - 0.055, 1.0), *run(LAST + 15.0, 8)], old=1
    ),
    'a gap of 1999 s': Stream(run(LAST + 1999.0, 8)),
    'a gap longer than the reach': Stream(run(LAST + 2001.0, 8), {'reset': 1}),
    'a jump back': Stream(run(START - 500.0, 8), {'reset': 1}, old=9),
    'a jump back by little': Stream(run(START + 0.005, 8), {'reset': 1}, old=9),
    'a stamp far ahead': Stream([('y', 1e6, 1.0), *AFTER], {'ahead': 1}),
    'a stamp within the reach': Stream([('y', LAST + 100.0, 1.0), *AFTER], {'ahead': 1}),
    'four within the reach': Stream([*run(LAST + 100.0, 4), *AFTER], {'ahead': 8}),
    'an input far ahead': Stream([('u', 1e6, 1.0), *AFTER], {'ahead': 1}),
    'four far ahead in a row': Stream(
        [*(('y', 1e6 + k, 1.0) for k in range(4)), *AFTER], {'ahead': 4}
    ),
    'one stamp far ahead again and again': Stream([*[('y', 1e6, 1.0)] * 9, *AFTER], {'ahead': 9}),
    'zero stamps now and then': Stream(
        [event for each in AFTER for event in (('y', 0.0, 1.0), each)], {'late': 16}
    ),
    'a late output': Stream([('y', LAST - 0.055, 1.0), *AFTER], old=1),
    'a late input, its step over': Stream([('u', LAST - 0.055, 1.0), *AFTER], old=1),
    'a late input in time for its step': Stream(
        [('u', LAST + 0.03, 1.0), ('u', LAST + 0.02, 1.0), ('y', LAST + 0.03, 1.0)],
        {'reordered': 1},
    ),
    'one stamp twice': Stream([('u', LAST, 9.0), ('y', LAST, 9.0), *AFTER], {'duplicate': 2}),
    'not a number': Stream([('u', LAST + 0.005, NAN), ('y', LAST + 0.005, -INF), *AFTER],
                           {'all_nan': 2}),
    'beyond its range': Stream([('y', LAST + 0.005, 1e300), *AFTER], {'huge': 1}),
    'no time of any clock': Stream([('y', 2e10, 1.0), ('u', -1e10, 1.0), *AFTER],
                                   {'out_of_range': 2}),
    'the first stamp far ahead': Stream(AFTER, {'late': 5, 'reset': 1}, lead=[('y', 1e6, 1.0)]),
}  # fmt: skip

INITIAL = {'x': 0.0, 'd': 0.0, 'g': 0.0}
GATE = GateSettings(reach=2.0 * DURATION)
BEFORE = Estimate(
    parameters={'d': 0.0, 'g': 0.0}, initial_state={'x': 0.0}, state={'x': 0.0}, stddev={},
    outcome=Outcome.CONVERGED, message='', t0=START, t1=LAST, stamp=round(LAST * S),
)  # fmt: skip


def told(counts: Any) -> dict[str, int]:
    """The counts of the gate that are not 0."""
    return {reason: counts[reason] for reason in COUNTS if counts[reason]}


def expected(stream: Stream, order: str) -> dict[str, int]:
    """The counts of whoever counts an old sample as `order`."""
    counts = dict(stream.counts)
    if stream.old:
        counts[order] = counts.get(order, 0) + stream.old
    return counts


@pytest.mark.parametrize('stream', STREAMS.values(), ids=STREAMS)
class TestOneStreamIsOneTimelineToAll:
    def test_to_a_window(self, stream: Stream) -> None:
        window = SlidingWindow(DURATION, n_inputs=1, n_outputs=1)
        breaks = sum(window.push(sample(event)) for event in (*stream.lead, *stream.events))
        assert breaks == stream.breaks
        assert told(window.counts) == expected(stream, 'reordered')

    @pytest.mark.parametrize('longest_gap', [0.0, 2.0 * DURATION])
    def test_to_a_recursive_observer_and_to_prediction(
        self, stream: Stream, longest_gap: float
    ) -> None:
        observer = Stepping(VESSEL, initial=INITIAL, longest_gap=longest_gap)
        prediction = Prediction(VESSEL, gate=GATE)
        for event in stream.lead:
            observer.absorb(sample(event))
            prediction.absorb(sample(event))
        prediction.start(BEFORE)
        begun = prediction.since is not None
        for event in stream.events:
            due = observer.absorb(sample(event))
            predicted = prediction.absorb(sample(event))
            if begun and not observer.counts['reset']:
                assert (predicted is not None) == due
                if due:
                    estimate = observer.estimate()
                    assert estimate is not None and predicted == estimate.stamp
        assert told(observer.counts) == expected(stream, 'late')
        assert (prediction.since is not None) == (begun and not stream.breaks)

    def test_to_the_forecast_of_a_replay(self, stream: Stream) -> None:
        forecaster = Forecaster(VESSEL, 20.0, GATE.reach, 1000)
        for event in stream.lead:
            forecaster.push(sample(event))
        forecaster.add(0, BEFORE)
        for event in (*stream.events, *run(LAST + 30.0, 5)):
            forecaster.push(sample(event))
        judged = [forecast.index for forecast in forecaster.judge()]
        goes_on = not stream.breaks and stream.events[-1][1] < LAST + 30.0
        assert judged == [0] * goes_on


def test_the_default_reach_is_that_of_the_nodes_default_window() -> None:
    defaults = {spec.name: spec.default for spec in COMMON}
    assert defaults['window.period'] == 0.0  # windows abut
    assert GateSettings().default_reach == 2.0 * defaults['window.duration']


class Kept:
    """A store that writes down what it is told; `passed` is set from outside."""

    def __init__(self) -> None:
        self.passed: int | None = None
        self.samples: list[tuple[str, int, list[float]]] = []

    def keep(self, role: str, stamp: int, values: Array) -> bool:
        found = any(each[:2] == (role, stamp) for each in self.samples)
        if not found:
            self.samples.append((role, stamp, values.tolist()))
        return not found

    def forget(self) -> None:
        self.samples.clear()
        self.passed = None

    @property
    def stamps(self) -> list[float]:
        return [stamp / S for _, stamp, _ in self.samples]


def gate_of(**settings: float) -> tuple[Gate, Kept]:
    store = Kept()
    return Gate.of(VESSEL, store, GateSettings(**settings)), store  # type: ignore[arg-type]


def outputs(gate: Gate, *times: float) -> list[bool]:
    return [gate.push(sample(('y', t, 1.0))) for t in times]


class TestGate:
    def test_what_has_been_passed_is_late_and_an_input_is_kept_all_the_same(self) -> None:
        gate, store = gate_of()
        outputs(gate, 1, 3, 5)
        store.passed = 3 * S
        outputs(gate, 2, 3, 4)
        gate.push(sample(('u', 6.0, 1.0)))
        gate.push(sample(('u', 2.0, 1.0)))
        assert store.stamps == [1, 3, 5, 4, 6, 2]
        assert (gate.counts['late'], gate.counts['reordered']) == (3, 1)

    def test_a_new_input_may_be_late_as_well(self) -> None:
        gate, store = gate_of()
        outputs(gate, 1, 3)
        store.passed = 3 * S
        gate.push(sample(('u', 2.0, 1.0)))
        assert store.stamps == [1, 3, 2] and gate.counts['late'] == 1

    def test_before_anything_is_settled_samples_within_the_reach_are_sorted_in(self) -> None:
        gate, store = gate_of(reach=10.0)
        outputs(gate, 100, 90.5, 89.5)
        assert store.stamps == [100, 90.5]
        assert (gate.counts['late'], gate.counts['reordered']) == (1, 1)

    def test_a_stamp_is_a_duplicate_wherever_it_stands(self) -> None:
        gate, store = gate_of()
        outputs(gate, 1, 2, 2, 1)
        assert store.stamps == [1, 2] and gate.counts['duplicate'] == 2

    def test_the_arrays_are_copied_into_one_layout(self) -> None:
        kept: list[Array] = []
        store = Kept()
        store.keep = lambda role, stamp, values: kept.append(values) or True  # type: ignore[method-assign,func-returns-value]
        gate = Gate([], [(-10.0, 10.0)] * 2, store, GateSettings())
        wide = np.array([[1.0, 9.0, 2.0, 9.0]])[0, ::2]
        gate.push(Sample(S, y=wide))
        wide[:] = 7.0
        assert kept[0].flags.c_contiguous and kept[0].tolist() == [1.0, 2.0]

    def test_held_values_are_copies(self) -> None:
        gate, store = gate_of(believed=2)
        outputs(gate, 1000)
        value = np.array([1.0])
        gate.push(Sample(0, y=value))
        value[0] = 2.0
        assert outputs(gate, 1) == [True]
        assert [values for _, _, values in store.samples] == [[1.0], [1.0]]

    def test_entries_that_are_no_measurement_are_taken_out(self) -> None:
        store = Kept()
        gate = Gate([], [(-10.0, 10.0)] * 2, store, GateSettings())
        gate.push(Sample(S, y=np.array([INF, 2.0])))
        assert np.isnan(store.samples[0][2][0]) and store.samples[0][2][1] == 2.0
        gate.push(Sample(2 * S, y=np.array([11.0, 3.0])))
        assert (gate.counts['nan'], gate.counts['huge'], gate.counts['all_nan']) == (1, 1, 0)

    def test_rare_inputs_are_not_ahead_while_outputs_go_on(self) -> None:
        gate, store = gate_of(reach=10.0)
        gate.push(sample(('u', 0.0, 1.0)))
        outputs(gate, *range(0, 100, 5))
        gate.push(sample(('u', 100.0, 2.0)))
        assert store.samples[-1] == ('input', 100 * S, [2.0])
        assert not any(gate.counts.values())

    def test_a_break_is_told_and_none_of_its_samples_is_lost(self) -> None:
        gate, store = gate_of(reach=10.0)
        gate.push(sample(('u', 1000.0, 1.0)))
        outputs(gate, 1000, 1001)
        gate.push(sample(('u', 0.0, 1.0)))
        assert outputs(gate, 1, 2, 3, 4, 5) == [False] * 4 + [True]
        assert store.stamps == [0, 1, 2, 3, 4, 5]
        assert gate.last_break is not None
        assert gate.last_break.startswith('output stamps jumped back from 1001.0 s to 1.0 s')
        assert gate.counts['reset'] == 1

    def test_the_default_reach_grows_with_the_interval(self) -> None:
        quick, slow = gate_of(), gate_of()
        outputs(quick[0], 0.01, 0.02, 0.03, *(2000.5 + k for k in range(5)))
        outputs(slow[0], 0, 300, 600, 3600)
        assert quick[0].counts['reset'] == 1
        assert slow[1].stamps == [0, 300, 600, 3600]

    def test_a_gap_within_the_reach_is_believed_when_five_tell_of_it(self) -> None:
        gate, store = gate_of(reach=100.0)
        outputs(gate, 0.01, 0.02, 0.03)
        gate.push(sample(('u', 15.0, 1.0)))
        outputs(gate, 15, 16, 17, 18)
        assert store.stamps == [0.01, 0.02, 0.03]
        outputs(gate, 19)
        assert store.stamps == [0.01, 0.02, 0.03, 15, 15, 16, 17, 18, 19]
        assert not any(gate.counts.values())

    def test_a_gap_says_nothing_of_the_pace(self) -> None:
        gate, store = gate_of(reach=1000.0)
        outputs(gate, *(0.01 * k for k in range(20)), *(900 + 0.01 * k for k in range(5)))
        outputs(gate, 950, 900.05)
        assert store.stamps[-1] == 900.05 and gate.counts['ahead'] == 1

    def test_a_gap_of_as_many_intervals_as_may_be_is_believed_at_once(self) -> None:
        gate, store = gate_of(reach=1e6)
        outputs(gate, 30, 60, 90, 20_000)
        assert store.stamps == [30, 60, 90, 20_000]

    def test_a_reach_that_is_given_does_not(self) -> None:
        gate, store = gate_of(reach=2.5)
        outputs(gate, 1, 2, 4.4, 7)
        assert store.stamps == [1, 2, 4.4]

    def test_a_model_of_small_steps_has_a_shorter_default_reach(self) -> None:
        model = replace(VESSEL, max_step=1e-3)
        assert GateSettings().within_steps(model).default_reach == pytest.approx(100.0)
        assert GateSettings().within_steps(THREE_TANK) == GateSettings()

    def test_a_plant_slower_than_any_guess_is_believed_and_then_known(self) -> None:
        gate, store = gate_of()
        hours = [3600.0 * k for k in range(1, 12)]
        for t in hours:
            gate.push(sample(('u', t, 1.0)))
            outputs(gate, t)
        assert store.stamps[-6:] == [t for t in hours[-3:] for _ in 'uy']
        assert gate.counts['reset'] <= 2

    def test_both_streams_must_reach_a_stamp(self) -> None:
        gate, _ = gate_of()
        outputs(gate, 5)
        assert gate.reached() is None
        gate.push(sample(('u', 3.0, 1.0)))
        assert gate.reached() == 3 * S
        alone = Gate([], [(-1.0, 1.0)], Kept(), GateSettings())  # type: ignore[arg-type]
        alone.push(sample(('y', 2.0, 1.0)))
        assert alone.reached() == 2 * S

    def test_after_a_reset_everything_is_new_but_the_counts(self) -> None:
        gate, store = gate_of(reach=10.0)
        outputs(gate, 1000, 1000, 5000)
        gate.reset()
        assert (gate.counts['duplicate'], gate.counts['ahead']) == (1, 1)
        outputs(gate, 1)
        assert store.stamps == [1000, 1] and gate.counts['late'] == 0

    def test_every_reason_is_explained(self) -> None:
        assert set(gate_of()[0].counts) == set(COUNTS)
        assert all(COUNTS.values())


class TestResumed:
    """A gate that begins where an earlier process has come, at 100 s."""

    def resumed(self) -> tuple[Gate, Kept]:
        gate, store = gate_of()
        gate.resume(100 * S)
        store.passed = 100 * S
        return gate, store

    @pytest.mark.parametrize('gap', [0.5, 30.0, 1e6])
    def test_time_goes_on_over_any_gap(self, gap: float) -> None:
        gate, store = self.resumed()
        assert outputs(gate, 100.0 + gap, 100.5 + gap) == [False, False]
        assert store.stamps == [100.0 + gap, 100.5 + gap]
        assert not any(gate.counts.values())

    def test_stamps_of_the_time_before_begin_a_new_timeline(self) -> None:
        gate, store = self.resumed()
        assert outputs(gate, 1, 2, 3, 4, 5) == [False] * 4 + [True]
        assert gate.last_break == (
            'output stamps jumped back from 100.0 s to 1.0 s: all samples forgotten'
        )
        assert store.stamps == [1, 2, 3, 4, 5]
        assert (gate.counts['late'], gate.counts['reset']) == (5, 1)
        # From there on nothing of the time before counts.
        assert outputs(gate, 6) == [False]
        assert store.stamps[-1] == 6

    def test_one_old_stamp_ends_nothing(self) -> None:
        gate, store = self.resumed()
        outputs(gate, 99.0, 130.0, 130.1)
        assert store.stamps == [130.0, 130.1]
        assert (gate.counts['late'], gate.counts['reset']) == (1, 0)

    def test_an_input_of_the_time_before_is_in_force_and_not_late(self) -> None:
        gate, store = self.resumed()
        gate.push(sample(('u', 40.0, 1.0)))
        outputs(gate, 130.0)
        assert store.stamps == [40.0, 130.0]
        assert gate.counts['late'] == 0

    def test_an_input_of_a_new_timeline_is_not_lost(self) -> None:
        """A set point may come once only."""
        gate, store = self.resumed()
        gate.push(sample(('u', 0.5, 7.0)))
        outputs(gate, 1, 2, 3, 4, 5)
        assert store.stamps == [0.5, 1, 2, 3, 4, 5]
        assert store.samples[0] == ('input', S // 2, [7.0])
