import threading

import pytest
from patience import patience

from obs_ros.interface.worker import Worker


class Waiting:
    """A worker, and the end of its jobs."""

    def __init__(self):
        self.ended = threading.Semaphore(0)
        self.worker = Worker(notify=self.ended.release)

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
    go = threading.Event()
    worker = Worker(notify=lambda: None)
    worker.start('wait', lambda: go.wait(patience(5.0)))
    assert not worker.close(0.05)
    go.set()
    assert worker.close(5.0)
