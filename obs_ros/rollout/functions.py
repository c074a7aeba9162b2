"""Copies of a plant's functions, with other helpers."""

from collections.abc import Callable
from types import CellType, FunctionType
from typing import Any

from obs_ros.fingerprint import of_library, used_globals


def rebuilt(
    function: Callable[..., Any],
    convert: Callable[..., Any],
    module: str,
    _above: tuple[FunctionType, ...] = (),
) -> FunctionType:
    """Copy a plain function with every plain function it calls by name replaced by `convert` of it.

    The copies belong to `module`: what is compiled of them looks that up, which is there wherever
    the function's own module has gone.

    Raises ValueError when it is no plain Python function, or calls itself.
    """
    if not isinstance(function, FunctionType):
        raise ValueError(f'{function!r} is not a plain Python function')

    if function in _above:
        raise ValueError(f'{function.__qualname__} calls itself')

    def converted(value: object) -> object:
        if not isinstance(value, FunctionType) or of_library(value):
            return value
        return convert(rebuilt(value, convert, module, (*_above, function)))

    scope = dict(function.__globals__)
    scope.update({name: converted(value) for name, value in used_globals(function)})
    cells = tuple(CellType(converted(cell.cell_contents)) for cell in function.__closure__ or ())
    copy = FunctionType(function.__code__, scope, function.__name__, function.__defaults__, cells)
    copy.__kwdefaults__ = function.__kwdefaults__
    copy.__module__ = module
    copy.__qualname__ = function.__qualname__
    return copy
