"""Threads that solve, shared by all observers of a process: the earliest deadline goes first."""

import heapq
import itertools
import threading
from collections.abc import Callable


class Pool:
    """Runs jobs in `size` threads; of those that wait, the one with the earliest deadline first.

    Where every job has the same time from its release to its deadline, none waits for ever: those
    that come later are due later (Liu & Layland 1973).
    """

    def __init__(self, size: int = 1) -> None:
        self._waiting: list[tuple[float, int, Callable[[], None]]] = []
        self._order = itertools.count()  # of jobs with one deadline
        self._changed = threading.Condition()
        self._open = True
        self._threads = [
            threading.Thread(target=self._run, name='solver', daemon=True) for _ in range(size)
        ]
        for thread in self._threads:
            thread.start()

    def put(self, due: float, job: Callable[[], None]) -> None:
        """Let a thread run `job`, which must not raise; `due` is in s of any one clock."""
        with self._changed:
            heapq.heappush(self._waiting, (due, next(self._order), job))
            self._changed.notify()

    def close(self) -> None:
        """End the threads, each when its job has ended; jobs that wait are dropped."""
        with self._changed:
            self._open = False
            self._waiting.clear()
            self._changed.notify_all()

    def _run(self) -> None:
        while (job := self._next()) is not None:
            job()
            del job  # it holds its node, which may be gone

    def _next(self) -> Callable[[], None] | None:
        with self._changed:
            while self._open and not self._waiting:
                self._changed.wait()
            return heapq.heappop(self._waiting)[2] if self._open else None
