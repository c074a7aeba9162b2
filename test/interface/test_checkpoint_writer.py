"""Tests of obs_ros.interface.checkpoint_writer."""

import itertools
import threading
import time

from patience import patience

from obs_ros.interface.checkpoint_writer import CheckpointWriter

LONG = 3600.0


def test_of_jobs_that_wait_only_the_newest_runs() -> None:
    writer, ran = CheckpointWriter(spacing=0.0), list[int]()
    go, begun = threading.Event(), threading.Event()

    def first() -> None:
        begun.set()
        assert go.wait(patience(5.0))
        ran.append(0)

    writer.put('a', first)
    assert begun.wait(patience(5.0))
    for k in (1, 2, 3):
        writer.put('a', lambda k=k: ran.append(k))
    go.set()
    assert writer.finish('a', patience(5.0))
    assert ran == [0, 3]
    assert writer.account('a').written == 2


def test_putting_a_job_does_not_wait_for_the_one_that_runs() -> None:
    writer, go = CheckpointWriter(), threading.Event()
    writer.put('a', lambda: go.wait(patience(5.0)))
    writer.put('a', lambda: None)
    assert not go.is_set()
    assert not writer.finish('a', 0.0)
    go.set()
    assert writer.finish('a', patience(5.0))


def test_what_a_job_raises_is_counted_and_told_and_the_next_one_tries_again() -> None:
    writer = CheckpointWriter(spacing=0.0)

    def full() -> None:
        raise OSError(28, 'No space left on device')

    for k in (1, 2):
        writer.put('a', full)
        assert writer.finish('a', patience(5.0))
        account = writer.account('a')
        assert (account.written, account.failed) == (0, k)
        assert 'No space left on device' in account.error
    writer.put('a', lambda: None)
    assert writer.finish('a', patience(5.0))
    assert (account.written, account.failed, account.error) == (1, 2, '')


def test_the_first_job_of_a_file_runs_at_once_and_the_next_after_the_spacing() -> None:
    writer, ran = CheckpointWriter(spacing=LONG), list[str]()
    done = threading.Event()

    def run() -> None:
        ran.append('first')
        done.set()

    writer.put('a', run)
    assert done.wait(patience(5.0))
    writer.put('a', lambda: ran.append('second'))
    other = threading.Event()
    writer.put('b', other.set)  # another file need not wait
    assert other.wait(patience(5.0))
    assert ran == ['first']
    # At the end of the node nothing is lost, and what forgets is not kept waiting.
    assert writer.finish('a', patience(5.0))
    assert ran == ['first', 'second']
    forgotten = threading.Event()
    writer.put('a', forgotten.set, at_once=True)
    assert forgotten.wait(patience(5.0))


def test_a_writer_that_nothing_waits_for_has_no_thread() -> None:
    def threads() -> list[threading.Thread]:
        return [each for each in threading.enumerate() if each.name == 'checkpoint']

    before, writer = threads(), CheckpointWriter(spacing=0.0)
    for k in (1, 2):
        writer.put('a', lambda: None)
        assert writer.finish('a', patience(5.0)) and writer.account('a').written == k
        for thread in set(threads()) - set(before):
            thread.join(patience(5.0))
            assert not thread.is_alive()


def test_nothing_to_finish() -> None:
    writer = CheckpointWriter()
    assert writer.finish('a', 0.0)
    assert writer.account('a').written == 0


def test_jobs_of_one_file_are_so_far_apart() -> None:
    spacing, moments = 0.05, list[float]()
    writer = CheckpointWriter(spacing)
    begun = [threading.Event() for _ in range(3)]
    for event in begun:

        def run(event: threading.Event = event) -> None:
            moments.append(time.monotonic())
            event.set()

        writer.put('a', run)
        assert event.wait(patience(5.0))
    assert all(b - a >= spacing for a, b in itertools.pairwise(moments))
