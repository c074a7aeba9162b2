"""The jobs of one observer in the threads of a pool, so that callbacks only append."""

import threading
from collections import deque
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from typing import Any

from obs_ros.interface.pool import Pool


@dataclass(frozen=True)
class Finished:
    """A job that ended, with its result or its exception."""

    kind: str
    result: Any
    error: Exception | None


class Worker:
    """Runs one job at a time in a thread of the pool, and never queues a second.

    `notify` is called in that thread when a job has ended; `collect` then hands it out. Everything
    but `notify` is for one and the same other thread. Without a pool it has a thread of its own.
    Each job runs within the context that `around` returned when it was started.
    """

    def __init__(
        self,
        notify: Callable[[], None],
        pool: Pool | None = None,
        around: Callable[[], AbstractContextManager[None]] = nullcontext,
    ) -> None:
        self._notify = notify
        self._around = around
        self._pool = Pool() if pool is None else pool
        self._alone = pool is None
        self._finished: deque[Finished] = deque()
        self._running: str | None = None
        self._discard = False
        self._closed = False
        self._working = threading.Lock()  # held while a job runs
        self._telling = threading.Lock()  # held while others are notified

    @property
    def running(self) -> str | None:
        """The kind of job that waits or runs, or whose result is not collected; None when idle."""
        return self._running

    def start(self, kind: str, job: Callable[[], Any], due: float = 0.0) -> None:
        """Start `job`, whose result is wanted at `due` (steady clock, s).

        Raises RuntimeError while another one runs.
        """
        if self._running is not None:
            raise RuntimeError(f'a job to {self._running} runs already')
        self._running = kind
        self._discard = False
        context = self._around()
        self._pool.put(due, lambda: self._run(kind, job, context))

    def discard(self) -> None:
        """Let nobody see the result of the job that runs now."""
        self._discard = True

    def collect(self) -> Finished | None:
        """Return the job that ended since, unless it was discarded, and be free for the next."""
        if not self._finished:
            return None
        finished = self._finished.popleft()
        self._running = None
        return None if self._discard else finished

    def close(self, timeout: float) -> bool:
        """Start no more; False when the job that runs has not ended within `timeout` s.

        Whatever it returns, nobody is notified any more.
        """
        with self._telling:
            self._closed = True
        if self._alone:
            self._pool.close()
        if ended := self._working.acquire(timeout=timeout):
            self._working.release()
        return ended

    def _run(
        self, kind: str, job: Callable[[], Any], context: AbstractContextManager[None]
    ) -> None:
        with self._working:
            if self._closed:
                return
            result, error = None, None
            try:
                with context:
                    result = job()
            except Exception as caught:
                error = caught
            self._finished.append(Finished(kind, result, error))
            with self._telling:
                if not self._closed:
                    self._notify()
