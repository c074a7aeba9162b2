"""The thread that writes checkpoints: a slow disk delays neither callbacks nor solves."""

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field

from obs_ros.core.texts import quoted


@dataclass
class Account:
    """What became of the writing of one file: `error` is of the last time, '' when it went well."""

    written: int = 0
    failed: int = 0
    error: str = ''


@dataclass
class _Order:
    """A job that waits, with the moment (steady clock, s) from which on it may run."""

    job: Callable[[], None]
    due: float


@dataclass
class _File:
    account: Account = field(default_factory=Account)
    order: _Order | None = None
    running: bool = False
    since: float = float('-inf')  # when the last job began


class CheckpointWriter:
    """Runs jobs that write files, by name: of those that wait for one file, the newest alone.

    Between two of one file are `spacing` s at least: memory cards wear out. What a job raises is
    counted and told, and the next one tries again. One thread serves all files, and is there while
    a job waits.
    """

    def __init__(self, spacing: float = 1.0) -> None:
        self._spacing = spacing
        self._files: dict[str, _File] = {}
        self._changed = threading.Condition()
        self._thread: threading.Thread | None = None

    def account(self, name: str) -> Account:
        """Return the account of one file, which goes on."""
        with self._changed:
            return self._files.setdefault(name, _File()).account

    def put(self, name: str, job: Callable[[], None], *, at_once: bool = False) -> None:
        """Let the thread run `job` in place of one that waits for this file; never blocks long."""
        with self._changed:
            file = self._files.setdefault(name, _File())
            due = time.monotonic() if at_once else file.since + self._spacing
            file.order = _Order(job, due)
            if self._thread is None:
                thread = threading.Thread(target=self._run, name='checkpoint', daemon=True)
                thread.start()
                self._thread = thread
            self._changed.notify_all()

    def finish(self, name: str, timeout: float) -> bool:
        """Run what waits for this file now; False when it has not ended within `timeout` s."""
        with self._changed:
            file = self._files.setdefault(name, _File())
            if file.order is not None:
                file.order.due = time.monotonic()
                self._changed.notify_all()
            return self._changed.wait_for(lambda: file.order is None and not file.running, timeout)

    def _run(self) -> None:
        while (found := self._next()) is not None:
            file, job = found
            error = ''
            try:
                job()
            except Exception as caught:
                error = quoted(caught)
            with self._changed:
                file.running = False
                file.account.error = error
                file.account.written += not error
                file.account.failed += bool(error)
                self._changed.notify_all()
            del found, file, job  # they hold an observer, which may be gone

    def _next(self) -> tuple[_File, Callable[[], None]] | None:
        """Wait for the next job, take it, and return it with its file; None if there is none."""
        with self._changed:
            while waiting := [(f.order, f) for f in self._files.values() if f.order is not None]:
                order, file = min(waiting, key=lambda each: each[0].due)
                wait = order.due - time.monotonic()
                if wait <= 0.0:
                    file.order, file.running, file.since = None, True, time.monotonic()
                    return file, order.job
                self._changed.wait(wait)
            self._thread = None
            return None
