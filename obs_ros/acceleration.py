"""Compile small numeric loops where Numba is installed; elsewhere they run as they are."""

from collections.abc import Callable
from typing import Any, TypeVar, cast

Function = TypeVar('Function', bound=Callable[..., Any])


def accelerated(function: Function) -> Function:
    """Return the function compiled at its first call and cached for later processes, if possible.

    Without Numba, or where it does not work, the function itself.
    """
    try:
        import numba
    except ImportError:
        return function
    compile_it: Any = numba.njit(cache=True, nogil=True, error_model='numpy')
    return cast(Function, compile_it(function))
