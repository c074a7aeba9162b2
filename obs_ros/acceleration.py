"""Compile small numeric loops where Numba is installed; elsewhere they run as they are."""

from collections.abc import Callable
from typing import Any, TypeVar, cast

Function = TypeVar('Function', bound=Callable[..., Any])


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
        return cast(Function, numba.njit(cache=True, **options)(function))
    except RuntimeError:  # no folder for the cache
        return cast(Function, numba.njit(**options)(function))
