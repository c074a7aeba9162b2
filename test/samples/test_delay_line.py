"""Tests of obs_ros.samples.delay_line."""

from dataclasses import replace
from random import Random

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from plants import BLOW_UP, LAG, square_wave

from obs_ros import Model, Record, Sample
from obs_ros.core.typing import Array
from obs_ros.models.three_tank import THREE_TANK
from obs_ros.samples.delay_line import DelayLine, Shifts, at_own_times
from obs_ros.samples.gate import Gate, GateSettings
from obs_ros.samples.merge import Role
from obs_ros.samples.window import SlidingWindow

S = 10**9
MS = 10**6
NAN = np.nan


class Kept:
    """A store that takes everything."""

    def __init__(self, passed: int | None = None) -> None:
        self.passed = passed
        self.samples: list[tuple[str, int, list[float]]] = []

    def keep(self, role: Role, stamp: int, values: Array) -> bool:
        self.samples.append((role, stamp // MS, values.tolist()))
        return True

    def forget(self) -> None:
        self.samples.clear()


def delayed(model: Model, inputs: list[float], outputs: list[float]) -> Model:
    return replace(
        model,
        inputs=[replace(v, delay=d) for v, d in zip(model.inputs, inputs, strict=True)],
        outputs=[replace(v, delay=d) for v, d in zip(model.outputs, outputs, strict=True)],
    )


def test_delays_shift_outputs_back_and_inputs_ahead() -> None:
    assert Shifts.of(delayed(LAG, [0.25], [0.05])) == Shifts((250 * MS,), (-50 * MS,))
    assert Shifts.of(delayed(LAG, [0.0], [0.0])) is None
    assert Shifts.of(LAG) is None


def test_samples_go_on_in_order_of_their_own_times() -> None:
    store = Kept()
    line = DelayLine(store, Shifts((200 * MS,), (0, -300 * MS)))
    for k in range(0, 1000, 100):
        line.keep('input', k * MS, np.array([float(k)]))
        line.keep('output', k * MS, np.array([k, k - 300.0]))
    times = [time for _, time, _ in store.samples]
    assert times == sorted(times)
    assert times[-1] == 600  # the slower output has brought no more
    for role, time, values in store.samples:
        expected = [time - 200.0] if role == 'input' else [time, time]
        early = role == 'output' and time < 0
        assert values == pytest.approx([NAN, time] if early else expected, nan_ok=True)


def test_two_parts_of_one_time_become_one_sample() -> None:
    store = Kept()
    line = DelayLine(store, Shifts((), (0, -20 * MS)))
    for k in range(0, 100, 20):
        assert line.keep('output', k * MS, np.array([k, k - 20.0]))
    assert [values for _, _, values in store.samples][1:] == [[k, k] for k in (0, 20, 40, 60)]
    assert not line.keep('output', 80 * MS, np.array([5.0, NAN]))


def test_what_waits_is_bounded_and_the_oldest_goes_on() -> None:
    store = Kept()
    line = DelayLine(store, Shifts((10**6 * S,), (0,)))
    for k in range(20010):
        line.keep('input', k * MS, np.zeros(1))
    assert len(store.samples) == 10
    line.forget()
    assert store.samples == []
    line.keep('output', 0, np.zeros(1))
    assert len(store.samples) == 1


@settings(max_examples=50, deadline=None)
@given(
    st.lists(st.integers(-9, 9), min_size=4, max_size=4),
    st.randoms(use_true_random=False),
)
def test_windows_of_delayed_signals_are_those_of_signals_in_time(
    delays: list[int], random: Random
) -> None:
    """Each signal is where it was measured, and nothing is late or out of order."""
    times = np.arange(0.0, 8.0, 0.1)
    u = np.column_stack([np.sin(times), np.cos(times)])
    y = np.column_stack([times**2, -times])
    settings = {'n_inputs': 2, 'n_outputs': 2}
    plain, late = SlidingWindow(2.0, **settings), SlidingWindow(
        2.0, **settings,
        shifts=Shifts(
            (delays[0] * 100 * MS, delays[1] * 100 * MS),
            (-delays[2] * 100 * MS, -delays[3] * 100 * MS),
        ),
    )  # fmt: skip
    stamped: dict[int, list[Sample]] = {}
    for k in range(times.size):
        plain.push(Sample(k * 100 * MS, u=u[k], y=y[k]))
        for i in range(2):
            partial = np.full(2, NAN)
            partial[i] = u[k, i]
            stamped.setdefault(k - delays[i], []).append(Sample(0, u=partial))
            partial = np.full(2, NAN)
            partial[i] = y[k, i]
            stamped.setdefault(k + delays[2 + i], []).append(Sample(0, y=partial))
    for k in sorted(stamped):
        u_k, y_k = np.full(2, NAN), np.full(2, NAN)
        for sample in stamped[k]:
            for whole, part in ((u_k, sample.u), (y_k, sample.y)):
                if part is not None:
                    whole[~np.isnan(part)] = part[~np.isnan(part)]
        parts = [('u', u_k), ('y', y_k)]
        random.shuffle(parts)
        for name, values in parts:
            if not np.isnan(values).all():
                late.push(Sample(k * 100 * MS + 10**15, **{name: values}))
    expected, found = list(iter(plain.take, None)), list(iter(late.take, None))
    assert len(found) >= 2
    for one, other in zip(expected, found, strict=False):
        shift = other.t - one.t - 1e6
        assert np.abs(shift).max() < 1e-6
        assert np.array_equal(one.u, other.u, equal_nan=True)
        assert np.array_equal(one.y[1:], other.y[1:], equal_nan=True)
    counts = {reason for reason, count in late.counts.items() if count}
    assert counts <= {'nan', 'before_input', 'skipped'}


def test_a_new_timeline_is_noticed_by_stamps_whatever_the_delays() -> None:
    store = Kept()
    model = delayed(THREE_TANK, [0.0, 0.3], [0.2, 0.0])
    gate = Gate.of(model, store, GateSettings())
    for k in range(50):
        gate.push(Sample((10**4 + k) * 100 * MS, u=np.ones(2), y=np.ones(2)))
    anew = [gate.push(Sample(k * 100 * MS, u=np.ones(2), y=np.full(2, 2.0))) for k in range(30)]
    assert anew.index(True) == 4 and anew.count(True) == 1
    outputs = [(time, values) for role, time, values in store.samples if role == 'output']
    assert outputs[-1] == (2700, [2.0, 2.0])
    assert gate.reached() == 2700 * MS


def test_a_record_goes_to_its_own_times() -> None:
    t = np.arange(0.0, 3.0, 0.1)
    record = Record(t, square_wave(t), np.sin(t), stamp=round(t[-1] * 1e9) + 10**18)
    assert at_own_times(LAG, record) is record
    found = at_own_times(delayed(LAG, [0.3], [0.05]), record)
    outputs = np.isfinite(found.y[:, 0])
    # The first input acts from 0.3 s on; the output stamped 0.4 s was measured at 0.35 s.
    assert found.t[outputs] == pytest.approx(t[4:] - 0.05)
    assert found.y[outputs, 0] == pytest.approx(np.sin(t[4:]))
    assert found.stamp == record.stamp - 50 * MS
    inputs = np.isfinite(found.u[:, 0])
    assert found.u[inputs, 0] == pytest.approx(
        np.append(square_wave(t)[0], square_wave(found.t[inputs][1:] - 0.3 + 1e-9))
    )


def test_a_record_too_short_for_its_delay_is_refused() -> None:
    t = np.arange(0.0, 3.0, 0.1)
    with pytest.raises(ValueError, match='lengthen the record: its inputs'):
        at_own_times(delayed(LAG, [5.0], [0.0]), Record(t, square_wave(t), np.sin(t)))


def test_inputs_that_may_act_late_are_kept_from_before_a_record() -> None:
    t = np.arange(0.0, 3.0, 0.1)
    model = replace(LAG, inputs=[replace(v, delay=(0.0, 0.5)) for v in LAG.inputs])
    assert Shifts.of(model) == Shifts((0,), (0,), 500 * MS)
    assert Shifts.of(model, {'u.delay': 0.2}) == Shifts((200 * MS,), (0,), 500 * MS)
    found = at_own_times(model, Record(t, square_wave(t), np.sin(t)))
    assert found.past is not None
    assert found.t == pytest.approx(t[5:]) and found.past[0] == pytest.approx(t[:6])
    assert found.past[1][:, 0] == pytest.approx(square_wave(t[:6]))
    late = replace(LAG, outputs=[replace(v, delay=(0.0, 0.5)) for v in LAG.outputs])
    record = Record(t, square_wave(t), np.sin(t))
    assert at_own_times(late, record) is record


def test_windows_begin_where_inputs_are_known_for_long_enough() -> None:
    window = SlidingWindow(
        1.0, 0.5, n_inputs=1, n_outputs=1, shifts=Shifts((0,), (0,), 300 * MS)
    )  # fmt: skip
    for k in range(40):
        window.push(Sample(k * 100 * MS, u=np.array([float(k)]), y=np.array([0.0])))
    records = list(iter(window.take, None))
    assert [round(float(r.t[0]), 6) for r in records] == pytest.approx(
        [0.3, 0.9, 1.4, 1.9, 2.4, 2.9][: len(records)]
    )
    for record in records:
        assert record.past is not None
        first = round(10.0 * float(record.t[0]))
        assert record.past[0] == pytest.approx(0.1 * np.arange(first - 3, first + 1))
        assert record.past[1][:, 0].tolist() == list(range(first - 3, first + 1))


def test_a_plant_without_inputs_has_delays_of_its_outputs() -> None:
    t = np.arange(0.0, 3.0, 0.1)
    model = delayed(BLOW_UP, [], [-0.1])
    assert at_own_times(model, Record(t, None, np.sin(t))).t == pytest.approx(t + 0.1)
