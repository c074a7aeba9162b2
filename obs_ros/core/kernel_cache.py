"""Compiled functions on disk, in place of Numba's own cache.

Numba judges by the calling file alone whether a stored function is stale, and lets every error in
a stored file out. Here a folder's name holds a hash of all that its code depends on, and a file
that does not load, for whatever reason, is compiled anew.
"""

import contextlib
import hashlib
import logging
import os
import pickle
import shutil
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from obs_ros.core.deadline import uncounted
from obs_ros.core.kernel_linking import let_go, make_known, symbols

FORMAT = 2  # of the files, in whose names it is
DIGEST = hashlib.sha256().digest_size
FOLDERS = ('obs_ros_kernels_*', 'obs_ros_accelerated_*')


@dataclass(frozen=True)
class CacheSettings:
    """Limits of the cache of compiled functions."""

    kept: int = 500  # folders of each kind, those used last: edited models leave old ones behind
    longest_wait: float = 60.0  # s for another process that compiles the same, some 10 s of work
    poll: float = 0.05  # s from one look at its lock to the next


SETTINGS = CacheSettings()

log = logging.getLogger(__name__)
_troubles: list[str] = []
_unloadable: set[type[Exception]] = set()
_thread = threading.local()


def cache_trouble() -> str:
    """Return why compiled code could not be stored for later processes; empty if it could."""
    return _troubles[-1] if _troubles else ''


def cache_folder() -> Path:
    """Return where compiled code lives: $OBS_ROS_CACHE, else the user's cache folder.

    A user without a home gets a path on which nothing can be written.
    """
    if own := os.environ.get('OBS_ROS_CACHE'):
        return Path(own)
    if base := os.environ.get('XDG_CACHE_HOME'):
        return Path(base) / 'obs_ros'
    try:
        return Path.home() / '.cache' / 'obs_ros'
    except RuntimeError:
        return Path(os.devnull) / 'obs_ros'


@contextlib.contextmanager
def missing_made_by(make: Callable[[Path], None]) -> Iterator[None]:
    """Call `make(path)` for each file that this thread misses in the block, before it compiles.

    What the call leaves missing is compiled in this process.
    """
    before = getattr(_thread, 'make', None)
    _thread.make = make
    try:
        yield
    finally:
        _thread.make = before


def stored(dispatcher: Any, name: Callable[[], str], announce: Callable[[], None]) -> Any:
    """Return the Numba function, with its compiled code kept in the folder `name` of the cache.

    The name, which must change with all that the code depends on, is asked for at the first
    compilation; `announce` is called before each one that the cache cannot spare. No deadline
    counts the time that compiling and loading take.
    """
    from numba.core.compiler_lock import global_compiler_lock

    if not hasattr(dispatcher, 'enable_caching'):  # NUMBA_DISABLE_JIT leaves plain functions
        return dispatcher
    cache = KernelCache(dispatcher.__name__, name)
    compile_or_load = dispatcher.compile

    def compile_once(signature: Any) -> Any:
        def there() -> bool:
            return signature in dispatcher.overloads or path.exists()

        path = cache.path(signature, dispatcher.targetctx)
        make = getattr(_thread, 'make', None)
        if make is not None and not there():
            with uncounted():
                make(path)
        # Within Numba's own lock, so that no thread waits for a file that this one holds.
        with uncounted(), global_compiler_lock:
            if there():
                return compile_or_load(signature)
            announce()
            with locked(path.parent):
                return compile_or_load(signature)

    dispatcher._cache = cache
    dispatcher.compile = compile_once
    return dispatcher


class KernelCache:
    """The cache that Numba asks for a function: one file per signature and processor."""

    def __init__(self, function: str, name: Callable[[], str]) -> None:
        self._function = function
        self._name = name
        self._folder: Path | None = None

    @property
    def cache_path(self) -> str:
        """The folder of the function's files."""
        if self._folder is None:
            self._folder = cache_folder() / self._name()
        return str(self._folder)

    def path(self, signature: Any, target: Any) -> Path:
        """Return the file of a signature (argument types), whether or not it exists."""
        import numba

        machine = target.codegen().magic_tuple()
        key = FORMAT, numba.__version__, sys.version_info[:2], signature, machine
        short = hashlib.sha256(repr(key).encode()).hexdigest()[:16]
        return Path(self.cache_path) / f'{self._function}-{short}.nbc'

    def load_overload(self, signature: Any, target: Any) -> Any:
        """Return the compiled function; None, said in the log, where its file does not load."""
        from numba.core.compiler import CompileResult

        rebuild: Any = CompileResult._rebuild
        path = self.path(signature, target)
        try:
            content = path.read_bytes()
            if hashlib.sha256(content[DIGEST:]).digest() != content[:DIGEST]:
                raise ValueError('damaged')
            called, compiled = pickle.loads(content[DIGEST:])
            make_known(called, target)
            code, *rest = pickle.loads(compiled)
            found = rebuild(target, code, *rest)
            let_go(found.library, code)
        except (FileNotFoundError, NotADirectoryError):
            return None
        except Exception as error:  # unpickling raises whatever the content makes it raise
            note_unloadable(path, error)
            return None
        with contextlib.suppress(OSError):
            os.utime(path.parent)  # used now; see prune
        return found

    def save_overload(self, signature: Any, compiled: Any) -> None:
        """Store the compiled function; where that fails it is lost when the process ends."""
        from numba.core import serialize

        dumps: Any = serialize.dumps
        path = self.path(signature, compiled.target_context)
        try:
            if compiled.library.has_dynamic_globals:
                raise ValueError(f'{self._function} holds addresses, as of a large table')
            content = pickle.dumps((symbols(compiled), dumps(compiled._reduce())))
            write(path, hashlib.sha256(content).digest() + content)
            prune(path.parent.parent)
        except Exception as error:  # nothing that storing meets may cost the result
            note_cache_trouble(path.parent, error)

    def flush(self) -> None:
        """Delete the function's files."""
        for path in Path(self.cache_path).glob(f'{self._function}-*.nbc'):
            path.unlink(missing_ok=True)


def remembered(folder: str, file: str, make: Callable[[], str]) -> str:
    """Return the text of a file in the cache; if there is none, the one made, stored for later.

    The folder's name must change with all that the text depends on.
    """
    path = cache_folder() / folder / file
    try:
        content = path.read_bytes()
        if hashlib.sha256(content[DIGEST:]).digest() != content[:DIGEST]:
            raise ValueError('damaged')
        return content[DIGEST:].decode()
    except (FileNotFoundError, NotADirectoryError):
        pass
    except (OSError, ValueError) as error:
        note_unloadable(path, error)
    text = make()
    content = text.encode()
    try:
        write(path, hashlib.sha256(content).digest() + content)
    except OSError as error:
        note_cache_trouble(path.parent, error)
    return text


def storable(folder: Path) -> bool:
    """Return whether files can be stored in a folder of the cache; if not, remember why."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return True
    except OSError as error:
        note_cache_trouble(folder, error)
        return False


def note_cache_trouble(where: object, error: Exception) -> None:
    """Remember, and say once, that nothing can be stored there."""
    why = getattr(error, 'strerror', None) or error
    reason = f'{where}: {why}; compiling in every process'
    if reason not in _troubles:
        log.warning('kernel cache %s', reason)
        _troubles.append(reason)


def note_unloadable(path: Path, error: Exception) -> None:
    """Say, once for each kind of error, that a file is of no use."""
    level = logging.DEBUG if type(error) in _unloadable else logging.WARNING
    _unloadable.add(type(error))
    log.log(level, 'kernel cache: %s does not load (%r); compiling anew', path, error)


def write(path: Path, content: bytes) -> None:
    """Write a file whole or not at all, whoever else reads or writes it; OSError if impossible."""
    path.parent.mkdir(parents=True, exist_ok=True)
    handle, draft = tempfile.mkstemp(dir=path.parent)
    try:
        with os.fdopen(handle, 'wb') as file:
            file.write(content)
        os.replace(draft, path)
    except BaseException:
        os.unlink(draft)
        raise


@contextlib.contextmanager
def locked(folder: Path, settings: CacheSettings = SETTINGS) -> Iterator[None]:
    """Keep other processes that compile into this folder waiting, `longest_wait` at most.

    Where files cannot be locked nobody waits: the same is then compiled twice.
    """
    with contextlib.ExitStack() as stack:
        with contextlib.suppress(OSError, ImportError):
            import fcntl

            folder.mkdir(parents=True, exist_ok=True)
            file = stack.enter_context(open(folder / 'lock', 'w'))
            deadline = time.monotonic() + settings.longest_wait
            while time.monotonic() < deadline:
                try:
                    fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
                    break
                except BlockingIOError:
                    time.sleep(settings.poll)
        yield


def prune(folder: Path, settings: CacheSettings = SETTINGS) -> None:
    """Delete the folders that were not used for longest: edited functions leave old ones."""
    for pattern in FOLDERS:
        with contextlib.suppress(OSError):  # another process prunes as well
            found = sorted(folder.glob(pattern), key=lambda path: path.stat().st_mtime)
            for path in found[: -settings.kept]:
                shutil.rmtree(path, ignore_errors=True)
