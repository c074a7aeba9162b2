"""Compile small numeric loops where Numba is installed; elsewhere they run as they are."""

import contextlib
import functools
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, TypeVar, cast

import numpy as np

from obs_ros.core.fingerprint import fingerprint
from obs_ros.core.kernel_cache import stored

Function = TypeVar('Function', bound=Callable[..., Any])

# Nothing calls compiled code from C: a wrapper for that would be compiled with every function.
OPTIONS: dict[str, Any] = {'nogil': True, 'error_model': 'numpy', 'no_cfunc_wrapper': True}


@dataclass(frozen=True)
class JitSettings:
    """When loops are compiled that may be interpreted."""

    patience: float = 0.05  # s that one is interpreted; loading it takes 0.01, compiling 0.2 to 1


SETTINGS = JitSettings()
_at_once: list[None] = []  # one entry for each that wants everything compiled
_thread = threading.local()


def accelerated(function: Function, elsewhere: Function | None = None) -> Function:
    """Return the function compiled at its first call and stored for later processes.

    Stored code is never stale: its folder's name holds a hash of the function and of all that it
    uses. Without Numba, `elsewhere`, which does the same on whole arrays, or else the function
    itself is returned.
    """
    try:
        import numba
    except ImportError:
        return elsewhere or function

    def name() -> str:
        text = f'{numba.__version__} {OPTIONS}'
        return f'obs_ros_accelerated_{function.__name__}_{fingerprint(text, function)}'

    compiled = numba.njit(**OPTIONS)(function)
    return cast(Function, stored(compiled, name, announce=lambda: None))


def unhurried(
    function: Function, elsewhere: Function | None = None, *, exact: bool = False
) -> Function:
    """Return the function as `accelerated` does, but interpreted until that has taken a while.

    A process that solves one window is through long before. Interpreted, the function has to give
    the same bits, in whatever it returns or changes: so products stand in place of powers, and of
    transcendental functions only those of `math`, which are those that Numba calls. An `exact`
    `elsewhere` gives those bits too, and is what runs meanwhile: sums of `np.add.accumulate` are
    those of a loop, others are not.
    """
    compiled = accelerated(function, elsewhere)
    if not hasattr(compiled, 'py_func'):
        return compiled
    return cast(Function, Unhurried(compiled, elsewhere if exact else None))


@contextlib.contextmanager
def at_once() -> Iterator[None]:
    """Let every function that is called meanwhile be compiled, or loaded, and not interpreted."""
    _at_once.append(None)
    try:
        yield
    finally:
        _at_once.pop()


class Unhurried:
    """A function that is interpreted at first; see `unhurried`."""

    def __init__(self, compiled: Any, meanwhile: Callable[..., Any] | None = None) -> None:
        functools.update_wrapper(self, compiled.py_func)
        self.py_func: Callable[..., Any] = compiled.py_func
        self.meanwhile = meanwhile or self.py_func
        self.compiled = compiled
        self._spent = 0.0  # s
        self._run: Callable[..., Any] = self._interpreted

    def __call__(self, *arguments: Any) -> Any:
        return self._run(*arguments)

    @property
    def _numba_type_(self) -> Any:
        """The type by which compiled callers know it."""
        return self.compiled._numba_type_

    @property
    def signatures(self) -> list[Any]:
        """The types of arguments that it is compiled for."""
        return list(self.compiled.signatures)

    def compile(self, signature: Any) -> Any:
        """Return the code for arguments of these types."""
        return self.compiled.compile(signature)

    def _interpreted(self, *arguments: Any) -> Any:
        if getattr(_thread, 'inside', False):  # a loop that is interpreted as well
            return self.meanwhile(*arguments)
        if _at_once or self._spent > SETTINGS.patience:
            self._run = self.compiled
            return self.compiled(*arguments)
        begin = time.thread_time()
        _thread.inside = True
        try:
            with np.errstate(all='ignore'):
                return as_compiled(self.meanwhile(*arguments))
        finally:
            _thread.inside = False
            self._spent += time.thread_time() - begin


def as_compiled(result: Any) -> Any:
    """Return a function's result in the types that compiled code returns."""
    if isinstance(result, tuple):
        return tuple(map(as_compiled, result))
    return result.item() if isinstance(result, np.generic) else result


def bound(function: Function, *arguments: Any) -> Function:
    """Return an accelerated function for arguments of just these types, whatever their shapes.

    A call skips Numba's look at each argument, which for a workspace of a dozen arrays takes longer
    than many a kernel. Nothing refuses arrays of another type or layout: they are misread.
    """
    compile_for = getattr(function, 'compile', None)
    if compile_for is None:
        return function
    import numba

    typeof: Callable[[Any], Any] = numba.typeof
    return cast(Function, compile_for(tuple(map(typeof, arguments))))
