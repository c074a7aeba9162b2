"""Kernels made by a child process: Numba's compiler would keep 200 MB here, and the GIL meanwhile.

The kernels come back through the cache on disk. Where they are there already no child is started.
"""

import contextlib
import json
import logging
import os
import subprocess
import sys
import tempfile
import threading
from collections.abc import Mapping
from contextlib import AbstractContextManager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from obs_ros.core.kernel_cache import missing_made_by, storable
from obs_ros.core.texts import one_line

CHILD = 'obs_ros.interface.compilation_child'


@dataclass(frozen=True)
class CompilationSettings:
    """Times of waiting for a child."""

    poll: float = 0.02  # s from one look for a kernel to the next: less than it takes to load one
    longest: float = 900.0  # s of a child, 20 to 50 s of work: a model's module may wait for ever


SETTINGS = CompilationSettings()

log = logging.getLogger(__name__)


class AbandonedError(RuntimeError):
    """Nobody waits any more for the kernel that a thread waits for."""


class Compilation:
    """The kernels that the jobs of one observer miss, made by a child process.

    What the child does not make, since it fails, dies or cannot store it, the job compiles.
    """

    def __init__(self) -> None:
        self._closed = threading.Event()

    def of(self, values: Mapping[str, Any]) -> AbstractContextManager[None]:
        """Return the context for a job of the observer that the node's parameters describe."""
        return missing_made_by(partial(self._make, values))

    @property
    def under_way(self) -> bool:
        """Whether a child compiles now, for this observer or another: who can wait need not ask."""
        return CHILDREN.busy

    def close(self) -> None:
        """Let no job wait any longer: one that does ends with AbandonedError.

        So does a child that no other observer has asked.
        """
        self._closed.set()
        CHILDREN.leave(self)

    def _make(self, values: Mapping[str, Any], path: Path) -> None:
        """Return when the file is there, or when no child will make it."""
        request = json.dumps(values)
        while not path.exists():
            child = CHILDREN.serving(self, request, path.parent)
            if child is None:
                return
            while not path.exists() and not child.ended.wait(SETTINGS.poll):
                if self._closed.is_set():
                    raise AbandonedError('the node ends')


class Children:
    """The child processes of this process: one at a time, and one for each request."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._newest: Child | None = None
        self._served: set[str] = set()

    @property
    def busy(self) -> bool:
        """Whether one runs."""
        newest = self._newest
        return newest is not None and not newest.ended.is_set()

    def serving(self, asker: Compilation, request: str, folder: Path) -> 'Child | None':
        """Return the child that runs, or else a new one; None if it would be the second.

        None as well where it could not store its kernels in `folder`.
        """
        with self._lock:
            if not self.busy:
                if request in self._served or not storable(folder):
                    return None
                self._served.add(request)
                try:
                    self._newest = Child(request)
                except OSError as error:
                    log.warning('compiling in this process: no other can be started: %s', error)
                    return None
            child = self._newest
            if child is not None and child.request == request:
                child.askers.add(asker)
            return child

    def leave(self, asker: Compilation) -> None:
        """End the child that runs if nobody else has asked it; who asks it again gets a new one."""
        with self._lock:
            child = self._newest
            if child is None or not self.busy or asker not in child.askers:
                return
            child.askers.remove(asker)
            if not child.askers:
                self._served.discard(child.request)
                child.stop()


CHILDREN = Children()


class Child:
    """A process that compiles what an observer needs, and ends with this one, however that ends.

    Raises OSError where it cannot be started.
    """

    def __init__(self, request: str) -> None:
        self.request = request
        self.askers: set[Compilation] = set()
        self.ended = threading.Event()
        self._stopped = False
        self._words = tempfile.TemporaryFile()  # noqa: SIM115 - see _watch
        try:
            # A session of its own: Ctrl-C in a terminal is for this process.
            self.process = subprocess.Popen(
                [sys.executable, '-P', '-m', CHILD], env=environment(), start_new_session=True,
                stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=self._words,
            )  # fmt: skip
        except OSError:
            self._words.close()
            raise
        threading.Thread(target=self._watch, daemon=True).start()

    def stop(self) -> None:
        """End it: nobody wants what it makes."""
        self._stopped = True
        self.process.kill()

    def _watch(self) -> None:
        """Ask, and keep the pipe open until the process ends: its other end tells it of our end."""
        assert self.process.stdin is not None
        try:
            with contextlib.suppress(OSError):  # it has died already
                self.process.stdin.write(self.request.encode() + b'\n')
                self.process.stdin.flush()
            try:
                code = self.process.wait(SETTINGS.longest)
            except subprocess.TimeoutExpired:
                self.process.kill()
                code = self.process.wait()
            if code and not self._stopped:
                log.warning('compiling in this process: another one failed: %s', self._why(code))
        finally:
            with contextlib.suppress(OSError):
                self.process.stdin.close()
            self._words.close()
            self.ended.set()

    def _why(self, code: int) -> str:
        """Return the last line that it wrote, or else its exit code."""
        self._words.seek(0)
        last = self._words.read().decode(errors='replace').strip().rpartition('\n')[2]
        return one_line(last) if last else f'exit code {code}'


def environment() -> dict[str, str]:
    """Return the environment of a process that imports what this one imports."""
    places = [each or os.getcwd() for each in sys.path]
    return {**os.environ, 'PYTHONPATH': os.pathsep.join(places)}
