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
    counted and told, and the next one tries again. One thread, which the first job starts, serves
    all files of a process.
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
                self._thread = threading.Thread(target=self._run, name='checkpoint', daemon=True)
                self._thread.start()
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
        while True:
            file, job = self._next()
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
            del file, job

    def _next(self) -> tuple[_File, Callable[[], None]]:
        """Wait for the next job, take it, and return it with its file."""
        with self._changed:
            while True:
                waiting = [(f.order.due, f) for f in self._files.values() if f.order is not None]
                due, file = min(waiting, key=lambda each: each[0], default=(None, None))
                wait = None if due is None else due - time.monotonic()
                if file is not None and file.order is not None and wait is not None and wait <= 0.0:
                    job, file.order = file.order.job, None
                    file.running, file.since = True, time.monotonic()
                    return file, job
                self._changed.wait(wait)
