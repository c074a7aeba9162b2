"""Tests of obs_ros.samples.merge."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from obs_ros.core.record import Sample
from obs_ros.samples.merge import Merge, MergeSettings

NAN = float('nan')


class Bench:
    """A merge of `inputs` and `outputs` entries, each on a topic of its own, or `together`."""

    def __init__(
        self, inputs: int = 0, outputs: int = 2, wait: float = 1.0, *, together: bool = False
    ) -> None:
        self.taken: list[tuple[int, list[float]]] = []
        self.arrivals: list[float] = []
        self.merge = Merge(wait, self._take)
        self.widths = {'u': inputs, 'y': outputs}
        self.topics = {}
        for name, role in (('u', 'input'), ('y', 'output')):
            width = self.widths[name]
            if together and width:
                topic = self.merge.topic(role, range(width), whole=True)  # type: ignore[arg-type]
                self.topics |= dict.fromkeys(((name, i) for i in range(width)), topic)
            else:
                for i in range(width):
                    topic = self.merge.topic(role, [i], whole=True)  # type: ignore[arg-type]
                    self.topics[name, i] = topic

    def add(self, stamp: int, entry: int = 0, now: float = 0.0, **value: float) -> None:
        """Take a message, `u=...` or `y=...`, and hand out what need not wait."""
        ((name, number),) = value.items()
        values = np.full(self.widths[name], NAN)
        values[entry] = number
        self.merge.add(self.topics[name, entry], stamp, values, now)
        self.merge.release(now)

    def _take(self, sample: Sample, arrival: float) -> None:
        values = sample.y if sample.u is None else sample.u
        assert values is not None
        self.taken.append((sample.stamp, values.tolist()))
        self.arrivals.append(arrival)

    @property
    def stamps(self) -> list[int]:
        return [stamp for stamp, _ in self.taken]


@pytest.fixture
def bench() -> Bench:
    return Bench()


class TestOneRole:
    def test_whole_samples_do_not_wait(self) -> None:
        bench = Bench(together=True)
        bench.add(1, y=1)
        bench.add(2, y=3)
        assert bench.stamps == [1, 2] and not len(bench.merge)

    def test_parts_of_one_stamp_become_one_sample(self, bench: Bench) -> None:
        bench.add(1, 0, y=1)
        assert not bench.taken
        bench.add(1, 1, y=2)
        assert bench.taken == [(1, [1, 2])]

    def test_an_entry_measured_twice_at_one_stamp_stays_two_samples(self, bench: Bench) -> None:
        bench.add(1, 0, y=1)
        bench.add(1, 0, y=5)
        bench.add(1, 1, y=2)
        assert bench.taken == [(1, [1, 2]), (1, pytest.approx([5, NAN], nan_ok=True))]

    def test_a_batch_of_one_topic_waits_for_the_batch_of_the_other(self, bench: Bench) -> None:
        for t in range(1, 6):
            bench.add(t, 0, y=t)
        for t in range(1, 6):
            bench.add(t, 1, y=-t)
        assert bench.taken == [(t, [t, -t]) for t in range(1, 6)]

    def test_a_silent_topic_holds_up_nobody_for_longer_than_the_wait(self, bench: Bench) -> None:
        bench.add(1, 0, now=0.0, y=1)
        bench.add(2, 0, now=0.6, y=2)
        bench.merge.release(0.99)
        assert not bench.taken
        bench.merge.release(1.0)
        assert bench.stamps == [1]
        bench.add(3, 0, now=1.7, y=3)
        assert bench.stamps == [1, 2]

    def test_what_comes_too_late_comes_out_at_once(self, bench: Bench) -> None:
        bench.add(1, 0, now=0.0, y=1)
        bench.add(5, 0, now=0.0, y=5)
        bench.merge.release(1.0)
        bench.add(3, 1, now=1.5, y=3)
        assert bench.stamps == [1, 5, 3]

    def test_entries_that_come_by_turns_on_one_topic_are_put_in_order(self) -> None:
        bench = Bench(outputs=0)
        topic = bench.merge.topic('output', [0, 1], whole=False)
        for stamp, values in ((5, [1, NAN]), (4, [NAN, 2]), (5, [NAN, 3])):
            bench.merge.add(topic, stamp, np.array(values), 0.0)
            bench.merge.release(0.0)
        assert bench.taken == [(4, pytest.approx([NAN, 2], nan_ok=True)), (5, [1, 3])]


class TestTimeThatBeginsAnew:
    def test_it_is_handed_on_in_the_order_of_each_topic(self, bench: Bench) -> None:
        """A restart inside a backlog: what each topic sent before it comes before what is after."""
        for entry in (0, 1):
            for stamp in (100, 101, 1, 2):
                bench.add(stamp, entry, y=entry)
        assert bench.stamps == [100, 101, 1, 2]

    def test_nothing_waits_for_stamps_of_the_old_time(self, bench: Bench) -> None:
        for stamp in (100, 1, 2):
            bench.add(stamp, 0, now=0.1 * stamp, y=1)
            bench.add(stamp, 1, now=0.1 * stamp, y=1)
        assert bench.stamps == [100, 1, 2]

    def test_what_one_topic_alone_had_sent_before_is_not_lost(self, bench: Bench) -> None:
        for stamp in (100, 101):
            bench.add(stamp, 0, y=1)
        bench.add(100, 1, y=1)
        for stamp in (1, 2):
            bench.add(stamp, 0, now=0.1, y=1)
            bench.add(stamp, 1, now=0.1, y=1)
        bench.merge.release(2.0)
        assert sorted(set(bench.stamps)) == [1, 2, 100, 101] and not len(bench.merge)

    def test_what_is_forgotten_never_comes(self) -> None:
        bench = Bench(1, 2)
        bench.add(1, 0, y=1)
        bench.merge.clear()
        bench.merge.release(9.0)
        bench.add(2, 1, y=2)
        assert not bench.taken and len(bench.merge) == 1

    def test_an_output_waits_for_an_input_that_begins_anew_as_well(self) -> None:
        bench = Bench(1, 1)
        for stamp in (10, 11, 12, 1, 2):
            bench.add(stamp, y=1)
            bench.add(stamp, u=1)
        assert bench.stamps == [10, 10, 11, 11, 12, 12, 1, 1, 2, 2]
        assert [values[0] for _, values in bench.taken] == [1.0] * 10

    def test_pace_and_reach_of_the_old_time_are_forgotten(self) -> None:
        bench = Bench(1, 2)
        for stamp in range(10, 20):
            bench.add(stamp, u=1)
            bench.add(stamp, 0, y=1)
            bench.add(stamp, 1, y=1)
        bench.merge.clear()
        bench.taken.clear()
        bench.add(5, 0, y=1)
        assert not bench.taken, 'the other output may come'
        bench.add(5, 1, y=1)
        assert bench.taken == [(5, [1, 1])], 'no input is due'


class TestOutputsAndInputs:
    def test_a_backlog_of_outputs_waits_for_that_of_inputs(self) -> None:
        """One topic delivers all that a stall held up before the other does: a stopped process."""
        bench = Bench(1, 1)
        for stamp in (1, 2, 3):
            bench.add(stamp, u=-stamp)
            bench.add(stamp, y=stamp)
        for stamp in range(4, 500):
            bench.add(stamp, now=0.01, y=stamp)
        assert bench.stamps[-1] == 3
        for stamp in range(4, 500):
            bench.add(stamp, now=0.02, u=-stamp)
        assert bench.taken == [(t, [sign * t]) for t in range(1, 500) for sign in (-1, 1)]

    def test_inputs_never_wait_for_outputs(self) -> None:
        bench = Bench(1, 1)
        for stamp in range(5):
            bench.add(stamp, u=1)
        assert bench.stamps == [0, 1, 2, 3, 4]

    def test_an_output_between_two_inputs_does_not_wait(self) -> None:
        bench = Bench(1, 1)
        for stamp in (0, 10, 20):
            bench.add(stamp, u=1)
        for stamp in range(21, 30):
            bench.add(stamp, y=1)
        assert bench.stamps == [0, 10, 20, *range(21, 30)]
        bench.add(30, y=1)
        assert bench.stamps[-1] == 29, 'the next input is due'
        bench.add(30, u=1)
        assert bench.stamps[-2:] == [30, 30]

    def test_a_rare_input_is_waited_for_once(self) -> None:
        bench = Bench(1, 1)
        for stamp in (0, 1):
            bench.add(stamp, u=1)
        bench.add(2, now=2.0, y=1)
        assert bench.stamps == [0, 1]
        bench.merge.release(2.0 + MergeSettings().longest_due)
        bench.add(3, now=3.0, y=1)
        bench.add(4, now=4.0, y=1)
        assert bench.stamps == [0, 1, 2, 3, 4], 'the wait was over, and is not begun again'
        bench.add(5, now=5.0, u=1)
        bench.add(6, now=6.0, y=1)
        assert bench.stamps[-1] == 5, 'now it is heard again'

    def test_it_goes_on_later_where_it_was_ended(self) -> None:
        bench = Bench(0, 1)
        bench.merge.add(bench.topics['y', 0], 1, np.array([1.0]), 0.0)
        bench.merge.add(bench.topics['y', 0], 2, np.array([2.0]), 0.0)
        assert not bench.merge.release(0.0, lambda: bool(bench.taken)) and bench.stamps == [1]
        assert bench.merge.release(0.0) and bench.stamps == [1, 2]

    def test_the_arrival_comes_with_the_sample(self) -> None:
        bench = Bench(0, 2)
        bench.add(1, 0, now=0.25, y=1)
        bench.add(1, 1, now=0.5, y=1)
        assert bench.arrivals == [0.5]


topics = st.lists(
    st.lists(st.integers(0, 60), min_size=1, max_size=30, unique=True).map(sorted),
    min_size=1, max_size=4,
)  # fmt: skip


@given(topics, st.randoms(use_true_random=False))
def test_however_topics_interleave_the_stream_is_the_same(topics, random) -> None:  # type: ignore[no-untyped-def]
    """Each topic in its own order, any interleaving: sorted, whole, nothing lost or made up."""
    bench = Bench(0, len(topics))
    queues = [list(stamps) for stamps in topics]
    while any(queues):
        i = random.choice([i for i, queue in enumerate(queues) if queue])
        stamp = queues[i].pop(0)
        bench.add(stamp, i, y=stamp)
    bench.merge.release(1.0)
    assert bench.stamps == sorted(set().union(*topics))
    for stamp, values in bench.taken:
        want = [float(stamp) if stamp in stamps else NAN for stamps in topics]
        assert values == pytest.approx(want, nan_ok=True)


@given(st.integers(1, 7), st.integers(1, 7), st.randoms(use_true_random=False))
def test_paced_inputs_are_in_force_when_their_outputs_come(every, other, random) -> None:  # type: ignore[no-untyped-def]
    """Whatever the two delays below the wait: no output passes an input of its time."""
    bench = Bench(1, 1)
    sent = [(t, 'u') for t in range(0, 60, every)] + [(t, 'y') for t in range(0, 60, other)]
    delays = {'u': random.random() * 0.09, 'y': random.random() * 0.09}
    arrivals = sorted((t / 100 + delays[name], name, t) for t, name in sent)
    for now, name, stamp in arrivals:
        bench.add(stamp, now=now, **{name: -1.0 if name == 'u' else 1.0})
    bench.merge.release(math.inf)
    outputs = [t for t, values in bench.taken if values[0] > 0.0]
    assert outputs == list(range(0, 60, other))
    for place, (stamp, values) in enumerate(bench.taken):
        before = [t for t, others in bench.taken[:place] if others[0] < 0.0]
        if values[0] > 0.0 and len(before) > 1:  # two inputs tell their pace
            assert before[: stamp // every + 1] == list(range(0, stamp + 1, every))
