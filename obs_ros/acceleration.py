"""Compile small numeric loops where Numba is installed; elsewhere they run as they are."""

import logging
from collections.abc import Callable
from typing import Any, TypeVar, cast

Function = TypeVar('Function', bound=Callable[..., Any])

log = logging.getLogger(__name__)
_troubles: list[str] = []


def cache_trouble() -> str:
    """Return why compiled code could not be stored for later processes; empty if it could."""
    return _troubles[-1] if _troubles else ''


def note_cache_trouble(where: object, error: OSError) -> None:
    """Remember, and say once, that nothing can be stored there."""
    reason = f'{where}: {error.strerror or error}; compiling in every process'
    if reason not in _troubles:
        log.warning('kernel cache %s', reason)
        _troubles.append(reason)


def storing(dispatcher: Any) -> Any:
    """Return a Numba function with a cache that a full disk keeps from storing, not from running.

    Numba itself lets the error out, and what it has compiled is lost.
    """
    cache = dispatcher._cache
    store = getattr(cache, 'save_overload', None)
    if store is None:
        return dispatcher

    def attempt(signature: Any, compiled: Any) -> None:
        try:
            store(signature, compiled)
        except OSError as error:
            note_cache_trouble(getattr(cache, 'cache_path', 'folder'), error)

    cache.save_overload = attempt
    return dispatcher


def accelerated(function: Function, elsewhere: Function | None = None) -> Function:
    """Return the function compiled at its first call and cached for later processes, if possible.

    Without Numba, or where it does not work, `elsewhere`, which does the same on whole arrays, or
    else the function itself; without a folder to write to, every process compiles anew.
    """
    try:
        import numba
    except ImportError:
        return elsewhere or function
    options: dict[str, Any] = {'nogil': True, 'error_model': 'numpy'}
    try:
        return cast(Function, storing(numba.njit(cache=True, **options)(function)))
    except RuntimeError:  # no folder for the cache
        return cast(Function, numba.njit(**options)(function))
