"""Jobs in the threads of a pool: the earliest deadline first."""

import threading

import pytest
from patience import patience

from obs_ros.interface.pool import Pool


class Held:
    """A pool whose threads are all held, until `go` is set."""

    def __init__(self, size: int = 1) -> None:
        self.pool, self.go = Pool(size), threading.Event()
        self.ended = threading.Semaphore(0)
        begun = threading.Semaphore(0)
        for _ in range(size):
            self.pool.put(0.0, lambda: begun.release() or self.go.wait(patience(10.0)))
        assert all(begun.acquire(timeout=patience(5.0)) for _ in range(size))

    def wait(self, count: int) -> None:
        self.go.set()
        assert all(self.ended.acquire(timeout=patience(5.0)) for _ in range(count))


@pytest.fixture
def held():
    held = Held()
    yield held
    held.go.set()
    held.pool.close()


def test_the_earliest_deadline_goes_first_and_of_equal_ones_what_came_first(held):
    done = []
    for name, due in (('c', 3.0), ('a', 1.0), ('b1', 2.0), ('b2', 2.0), ('now', -1.0)):
        held.pool.put(due, lambda name=name: done.append(name) or held.ended.release())
    held.wait(5)
    assert done == ['now', 'a', 'b1', 'b2', 'c']


def test_one_that_is_always_due_keeps_none_waiting_for_ever(held):
    """Each of its jobs puts the next: those of others that were due before come first."""
    done = []

    def hungry(due: float) -> None:
        done.append('hungry')
        if due < 8.0:
            held.pool.put(due + 1.0, lambda: hungry(due + 1.0))
        else:
            held.ended.release()

    held.pool.put(1.0, lambda: hungry(1.0))
    for due in (2.5, 4.5):
        held.pool.put(due, lambda: done.append('other'))
    held.wait(1)
    assert done == ['hungry'] * 2 + ['other'] + ['hungry'] * 2 + ['other'] + ['hungry'] * 4


def test_as_many_jobs_run_at_once_as_there_are_threads():
    held = Held(size=3)  # it waits until three have begun
    held.wait(0)
    held.pool.close()


def test_closing_drops_the_jobs_that_wait():
    held, done = Held(), []
    held.pool.put(1.0, lambda: done.append(1))
    held.pool.close()
    held.go.set()
    held.pool.put(0.0, lambda: done.append(2))
    assert done == []
