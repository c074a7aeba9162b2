"""The thread that solves, so that callbacks only append."""

import queue
import threading
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Finished:
    """A job that ended, with its result or its exception."""

    kind: str
    result: Any
    error: Exception | None


class Worker:
    """Runs one job at a time in a thread of its own, and never queues a second.

    `notify` is called in that thread when a job has ended; `collect` then hands it out. Everything
    but `notify` is for one and the same other thread.
    """

    def __init__(self, notify: Callable[[], None]) -> None:
        self._notify = notify
        self._jobs: queue.SimpleQueue[tuple[str, Callable[[], Any]] | None] = queue.SimpleQueue()
        self._finished: deque[Finished] = deque()
        self._running: str | None = None
        self._discard = False
        self._thread = threading.Thread(target=self._run, name='solver', daemon=True)
        self._thread.start()

    @property
    def running(self) -> str | None:
        """The kind of job that runs, or whose result is not collected yet; None when idle."""
        return self._running

    def start(self, kind: str, job: Callable[[], Any]) -> None:
        """Start `job`; raises RuntimeError while another one runs."""
        if self._running is not None:
            raise RuntimeError(f'a job to {self._running} runs already')
        self._running = kind
        self._discard = False
        self._jobs.put((kind, job))

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
        """End the thread; False when its job has not ended within `timeout` s."""
        self._jobs.put(None)
        self._thread.join(timeout)
        return not self._thread.is_alive()

    def _run(self) -> None:
        while (job := self._jobs.get()) is not None:
            kind, work = job
            result, error = None, None
            try:
                result = work()
            except Exception as caught:
                error = caught
            self._finished.append(Finished(kind, result, error))
            self._notify()
