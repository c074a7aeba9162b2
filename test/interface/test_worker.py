import threading

import pytest
from patience import patience

from obs_ros.interface.pool import Pool
from obs_ros.interface.worker import Worker


class Waiting:
    """A worker, and the end of its jobs."""

    def __init__(self, pool=None):
        self.ended = threading.Semaphore(0)
        self.worker = Worker(self.ended.release, pool)

    def collect(self):
        assert self.ended.acquire(timeout=patience(5.0))
        return self.worker.collect()


@pytest.fixture
def waiting():
    waiting = Waiting()
    yield waiting
    assert waiting.worker.close(5.0)


def test_jobs_run_in_another_thread_and_hand_back_their_result(waiting):
    waiting.worker.start('name', lambda: threading.current_thread().name)
    finished = waiting.collect()
    assert (finished.kind, finished.result, finished.error) == ('name', 'solver', None)
    assert waiting.worker.running is None


def test_one_job_at_a_time(waiting):
    go = threading.Event()
    waiting.worker.start('wait', lambda: go.wait(patience(5.0)))
    assert waiting.worker.running == 'wait' and waiting.worker.collect() is None
    with pytest.raises(RuntimeError, match='wait runs already'):
        waiting.worker.start('more', int)
    go.set()
    assert waiting.collect().result is True


def test_an_exception_is_handed_back(waiting):
    waiting.worker.start('fail', lambda: 1 / 0)
    assert isinstance(waiting.collect().error, ZeroDivisionError)
    waiting.worker.start('go on', lambda: 3)
    assert waiting.collect().result == 3


@pytest.mark.parametrize('ended', [False, True])
def test_discarded_results_are_not_handed_out(waiting, ended):
    go = threading.Event()
    waiting.worker.start('wait', lambda: go.wait(patience(5.0)))
    if ended:
        go.set()
        assert waiting.ended.acquire(timeout=patience(5.0))
        waiting.ended.release()
    waiting.worker.discard()
    go.set()
    assert waiting.collect() is None
    assert waiting.worker.running is None
    waiting.worker.start('next', lambda: 1)
    assert waiting.collect().result == 1


def test_closing_does_not_wait_for_ever():
    begun, go = threading.Event(), threading.Event()
    worker = Worker(notify=lambda: None)
    worker.start('wait', lambda: begun.set() or go.wait(patience(5.0)))
    assert begun.wait(patience(5.0))
    assert not worker.close(0.05)
    go.set()
    assert worker.close(5.0)


def test_workers_share_the_threads_of_a_pool_and_one_that_closes_leaves_the_others():
    pool, begun, go = Pool(), threading.Event(), threading.Event()
    told = []
    one, other = (Worker(lambda name=name: told.append(name), pool) for name in ('one', 'other'))
    one.start('wait', lambda: begun.set() or go.wait(patience(5.0)), due=1.0)
    assert begun.wait(patience(5.0))
    other.start('never', lambda: told.append('began'), due=2.0)
    assert other.running == 'never'
    assert other.close(0.0)  # its job has not begun, and will not
    assert not one.close(0.0)
    go.set()
    assert one.close(patience(5.0))
    third = Waiting(pool)
    third.worker.start('go on', lambda: 3)
    assert third.collect().result == 3
    assert told == []
    pool.close()


def test_once_closed_nobody_is_notified():
    """Not even by a job that ends at that moment: what `notify` needs may be gone."""
    begun, go, told = threading.Event(), threading.Event(), []

    def notify():
        begun.set()
        assert go.wait(patience(5.0))
        told.append(closing.is_alive())

    worker = Worker(notify)
    worker.start('solve', lambda: None)
    assert begun.wait(patience(5.0))
    closing = threading.Thread(target=worker.close, args=(0.0,))
    closing.start()
    closing.join(0.1)
    go.set()
    closing.join(patience(5.0))
    assert told == [True] and not closing.is_alive()
