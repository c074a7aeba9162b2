"""Compile small numeric loops where Numba is installed; elsewhere they run as they are."""

from collections.abc import Callable
from typing import Any, TypeVar, cast

from obs_ros.core.fingerprint import fingerprint
from obs_ros.core.kernel_cache import stored

Function = TypeVar('Function', bound=Callable[..., Any])

OPTIONS: dict[str, Any] = {'nogil': True, 'error_model': 'numpy'}


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
