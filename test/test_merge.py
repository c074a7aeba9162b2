"""Tests of obs_ros.merge."""

from collections.abc import Sequence

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from obs_ros.merge import Merge

NAN = float('nan')


class Bench:
    def __init__(self, width: int = 2, wait: float = 1.0) -> None:
        self.taken: list[tuple[int, list[float]]] = []
        self.merge = Merge(width, wait, lambda t, v: self.taken.append((t, v.tolist())))

    def add(self, stamp: int, values: Sequence[float], now: float = 0.0) -> None:
        self.merge.add(stamp, np.array(values, dtype=np.float64), now)

    @property
    def stamps(self) -> list[int]:
        return [stamp for stamp, _ in self.taken]


@pytest.fixture
def bench() -> Bench:
    return Bench()


def test_whole_samples_do_not_wait(bench: Bench) -> None:
    bench.add(1, (1, 2))
    bench.add(2, (3, 4))
    assert bench.taken == [(1, [1, 2]), (2, [3, 4])] and not len(bench.merge)


def test_parts_of_one_stamp_become_one_sample(bench: Bench) -> None:
    bench.add(1, (1, NAN))
    assert not bench.taken
    bench.add(1, (NAN, 2))
    assert bench.taken == [(1, [1, 2])]


def test_an_entry_measured_twice_at_one_stamp_stays_two_samples(bench: Bench) -> None:
    bench.add(1, (1, NAN))
    bench.add(1, (5, NAN))
    bench.add(1, (NAN, 2))
    assert bench.taken == [(1, [1, 2]), (1, pytest.approx([5, NAN], nan_ok=True))]


def test_a_batch_of_one_topic_waits_for_the_batch_of_the_other(bench: Bench) -> None:
    for t in range(1, 6):
        bench.add(t, (t, NAN))
    for t in range(1, 6):
        bench.add(t, (NAN, -t))
    assert bench.taken == [(t, [t, -t]) for t in range(1, 6)]


def test_a_silent_topic_holds_up_nobody_for_longer_than_the_wait(bench: Bench) -> None:
    bench.add(1, (1, NAN), now=0.0)
    bench.add(2, (2, NAN), now=0.6)
    bench.merge.release(0.99)
    assert not bench.taken
    bench.merge.release(1.0)
    assert bench.stamps == [1]
    bench.add(3, (3, NAN), now=1.7)
    assert bench.stamps == [1, 2]


def test_what_comes_too_late_comes_out_at_once(bench: Bench) -> None:
    bench.add(1, (1, NAN), now=0.0)
    bench.add(5, (5, NAN), now=0.0)
    bench.merge.release(1.0)
    bench.add(3, (NAN, 3), now=1.5)
    assert bench.stamps == [1, 5, 3]


def test_time_that_begins_anew_is_handed_on(bench: Bench) -> None:
    bench.add(100, (1, 1))
    bench.add(101, (1, NAN))
    bench.add(1, (1, 1), now=0.1)
    bench.add(2, (2, 2), now=0.2)
    assert bench.stamps == [100, 1, 2]
    bench.merge.release(1.0)
    assert bench.stamps == [100, 1, 2, 101], 'the stray is for the window to drop'


def test_what_is_forgotten_never_comes(bench: Bench) -> None:
    bench.add(1, (1, NAN))
    bench.merge.clear()
    bench.merge.release(9.0)
    bench.add(2, (NAN, 2))
    assert not bench.taken and len(bench.merge) == 1


topics = st.lists(
    st.lists(st.integers(0, 60), min_size=1, max_size=30, unique=True).map(sorted),
    min_size=1, max_size=4,
)  # fmt: skip


@given(topics, st.randoms(use_true_random=False))
def test_however_topics_interleave_the_stream_is_the_same(topics, random) -> None:  # type: ignore[no-untyped-def]
    """Each topic in its own order, any interleaving: sorted, whole, nothing lost or made up."""
    bench = Bench(len(topics), wait=1.0)
    queues = [list(stamps) for stamps in topics]
    while any(queues):
        i = random.choice([i for i, queue in enumerate(queues) if queue])
        stamp = queues[i].pop(0)
        values = [NAN] * len(topics)
        values[i] = stamp
        bench.add(stamp, values)
    bench.merge.release(1.0)
    assert bench.stamps == sorted(set().union(*topics))
    for stamp, values in bench.taken:
        want = [float(stamp) if stamp in stamps else NAN for stamps in topics]
        assert values == pytest.approx(want, nan_ok=True)
