"""What an observer has learned, kept in a file from one start of its node to the next."""

import contextlib
import os
import threading
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any

from obs_ros.core.model_identity import Identity, behaviour, declared, difference
from obs_ros.core.plain_data import Shapes, from_plain, to_plain
from obs_ros.core.texts import one_line, quoted
from obs_ros.interface.checkpoint_file import (
    decode,
    encode,
    lock,
    read,
    remove,
    set_aside,
    write,
)
from obs_ros.interface.checkpoint_writer import Account, CheckpointWriter
from obs_ros.interface.progress import Progress
from obs_ros.interface.status import Level
from obs_ros.observers.base import Remembering, load_observer, remembers

SHAPES = Shapes({'Identity.behaviour': 'P S'}, not_finite=frozenset({'Identity.behaviour'}))
PATIENCE = 0.3  # s that the end of a node waits for the disk


def checkpoint_path(given: str, node: str) -> Path | None:
    """Return the file that a parameter names for a node of that full name; None for none.

    In a folder the node's name is that of the file, with dots for slashes, so that many nodes may
    share it. Raises ValueError for a folder that is not there, and for what is no file.
    """
    if not given:
        return None
    try:
        path = Path(given).expanduser().resolve()
        if path.is_dir():
            return path / f'{node.strip("/").replace("/", ".")}.checkpoint'
        folder = path if given.endswith('/') else path.parent
        missing, other = not folder.is_dir(), path.exists() and not path.is_file()
    except (OSError, ValueError, RuntimeError) as error:
        raise ValueError(f'checkpoint: name a file or a folder: {one_line(error)}') from error
    if missing:
        raise ValueError(f'checkpoint: make the folder first: there is no {quoted(str(folder))}')
    if other:
        raise ValueError(f'checkpoint: name a file or a folder: {quoted(given)} is neither')
    return path


class Checkpoint:
    """The file of one observer; without a path nothing is kept.

    `told` says in one sentence what became of the file that was there at the start. One thread
    calls all methods; a `writer` writes. The file is locked for this node: raises ValueError where
    another one has it.
    """

    def __init__(self, path: Path | None = None, writer: CheckpointWriter | None = None) -> None:
        self._path, self.told = path, ''
        self._taken_up = False  # and nothing kept since
        self._writer = writer or CheckpointWriter()
        self._lock: int | None = None
        if path is None:
            return
        try:
            self._lock = lock(path)
        except BlockingIOError as error:
            raise ValueError(
                'checkpoint: give each node a file of its own, or name a folder: another node has '
                f'{quoted(str(path))}'
            ) from error
        except OSError:
            pass  # the first write tells

    @classmethod
    def of(
        cls, values: Mapping[str, Any], node: str, writer: CheckpointWriter | None = None
    ) -> 'Checkpoint':
        """Return the checkpoint that the parameters of a node of that full name ask for.

        Raises ValueError for a path that is none, and for an observer that remembers nothing.
        """
        path, observer = checkpoint_path(values['checkpoint'], node), values['observer']
        if path is not None and not remembers(load_observer(observer)):
            raise ValueError(
                f'leave checkpoint empty, or take observer sliding_window: {quoted(observer)} '
                'begins anew at every start'
            )
        return cls(path, writer)

    @property
    def account(self) -> Account:
        """What became of the writing."""
        return self._writer.account(str(self._path))

    @property
    def figures(self) -> Mapping[str, object]:
        """Figures for /diagnostics; none without a path."""
        if self._path is None:
            return {}
        account = self.account
        found = {
            'checkpoint': self.told,
            'checkpoint.written': account.written,
            'checkpoint.failed': account.failed,
        }
        return {**found, 'checkpoint.error': account.error} if account.error else found

    def tell(self, progress: Progress) -> None:
        """Let the diagnostics have the figures, and what is wrong."""
        progress.checkpoint, progress.unsaved = self.figures, self.trouble

    @property
    def trouble(self) -> str:
        """Why the last write failed, with a remedy; '' when it went well."""
        error = '' if self._path is None else self.account.error
        if not error:
            return ''
        return f'look at the disk and rights of {self._path}: no checkpoint was written: {error}'

    def take_up(self, observer: Any) -> list[tuple[Level, str]]:
        """Let a new observer go on with what the file says; return lines for the log.

        What is refused is set aside, so that nothing writes over it.
        """
        if self._path is None:
            return []
        level = self._take_up(observer, self._path)
        return [(level, f'checkpoint {self._path}: {self.told}')]

    def _take_up(self, observer: Remembering, path: Path) -> Level:
        try:
            content = decode(read(path))
            if content.keys() != {'identity', 'memory'}:
                raise ValueError(f'it has {quoted(sorted(content))}, not identity and memory')
            there = from_plain(Identity, content['identity'], SHAPES, 'identity')
            if reason := difference(there, identity_of(observer)):
                raise ValueError(reason)
            observer.recall(content['memory'])
        except FileNotFoundError:
            self.told = 'begun without: there was no file yet'
            return Level.OK
        # Whatever a file may hold, the node runs without it.
        except Exception as error:
            self.told = f'begun anew: {one_line(error)}'
            with contextlib.suppress(OSError):
                self.told += f'; kept as {set_aside(path)}'
            return Level.WARN
        self._taken_up, self.told = True, 'taken up'
        return Level.OK

    def keep(self, observer: Any) -> None:
        """Let the thread write what the observer knows; not for while it estimates."""
        if self._path is not None and (memory := observer.memory) is not None:
            self._taken_up = False
            self._writer.put(str(self._path), partial(_write, self._path, observer, memory))

    def begin_anew(self, why: str) -> None:
        """Note that nobody knows any more what the file says; the next window writes over it."""
        self._taken_up, self.told = False, f'begun anew: {why}'

    def forget(self, why: str) -> None:
        """Take the file away: the observer was reset."""
        if self._path is not None:
            self.begin_anew(why)
            self._writer.put(str(self._path), partial(remove, self._path), at_once=True)

    def failed(self) -> bool:
        """Forget what was taken up if the first window with it failed; return whether it was so.

        What makes an estimate fail must not come back at every start.
        """
        failed = self._taken_up
        if failed:
            self.forget('no window could be solved with what the file said')
        return failed

    def close(self) -> bool:
        """Write what waits, and let others have the file; False where the disk is too slow."""
        if self._path is None:
            return True
        ended = self._writer.finish(str(self._path), PATIENCE)
        if self._lock is not None:
            handle, self._lock = self._lock, None
            if ended:
                os.close(handle)
            else:  # whoever comes next must not read before this is written
                threading.Thread(target=self._release, args=(handle,), daemon=True).start()
        return ended

    def _release(self, handle: int) -> None:
        self._writer.finish(str(self._path), threading.TIMEOUT_MAX)
        os.close(handle)


def identity_of(observer: Remembering) -> Identity:
    """Return all without which what an observer learned means something else."""
    model = observer.model
    words = {'observer': type(observer).__name__, **declared(model), **observer.identity}
    return Identity(words, behaviour(model))


def _write(path: Path, observer: Remembering, memory: Any) -> None:
    write(path, encode({'identity': to_plain(identity_of(observer)), 'memory': to_plain(memory)}))
