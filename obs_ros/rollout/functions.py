"""Look into a plant's functions: what they depend on, and copies with other helpers."""

import hashlib
from collections.abc import Callable, Iterator
from types import CellType, CodeType, FunctionType, ModuleType
from typing import Any

import numpy as np


def fingerprint(text: str, *functions: Callable[..., Any]) -> str:
    """Hash a text and functions: their code, constants, and the globals they use, to any depth."""
    digest = hashlib.sha256(text.encode())
    seen: set[int] = set()
    for function in functions:
        _hash_value(digest, function, seen)
    return digest.hexdigest()[:24]


def rebuilt(
    function: Callable[..., Any],
    convert: Callable[..., Any],
    _above: tuple[FunctionType, ...] = (),
) -> FunctionType:
    """Copy a plain function with every plain function it calls by name replaced by `convert` of it.

    Raises ValueError when it is no plain Python function, or calls itself.
    """
    if not isinstance(function, FunctionType):
        raise ValueError(f'{function!r} is not a plain Python function')

    if function in _above:
        raise ValueError(f'{function.__qualname__} calls itself')

    def converted(value: object) -> object:
        if not isinstance(value, FunctionType) or _of_library(value):
            return value
        return convert(rebuilt(value, convert, (*_above, function)))

    scope = dict(function.__globals__)
    scope.update({name: converted(value) for name, value in _used_globals(function)})
    cells = tuple(CellType(converted(cell.cell_contents)) for cell in function.__closure__ or ())
    copy = FunctionType(function.__code__, scope, function.__name__, function.__defaults__, cells)
    copy.__kwdefaults__ = function.__kwdefaults__
    copy.__module__ = function.__module__
    copy.__qualname__ = function.__qualname__
    return copy


def _used_globals(function: FunctionType) -> Iterator[tuple[str, object]]:
    for name in sorted(_names(function.__code__)):
        if name in function.__globals__:
            yield name, function.__globals__[name]


def _names(code: CodeType) -> set[str]:
    found = set(code.co_names)
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            found |= _names(constant)
    return found


def _hash_value(digest: Any, value: Any, seen: set[int]) -> None:
    value = getattr(value, 'py_func', value)  # a function that its author compiled already
    if _of_library(value):
        digest.update(f'{value.__module__}.{value.__qualname__}'.encode())
    elif isinstance(value, FunctionType):
        if id(value) in seen:
            return
        seen.add(id(value))
        _hash_value(digest, value.__code__, seen)
        _hash_value(digest, value.__defaults__, seen)
        cells = (('', cell.cell_contents) for cell in value.__closure__ or ())
        for name, used in (*_used_globals(value), *cells):
            digest.update(name.encode())
            _hash_value(digest, used, seen)
            if isinstance(used, ModuleType) and not _is_library(used.__name__):
                # Constants by module.NAME: the names of all attributes stand in one list.
                for attribute in sorted(_names(value.__code__)):
                    _hash_value(digest, getattr(used, attribute, None), seen)
    elif isinstance(value, CodeType):
        digest.update(value.co_code)
        digest.update(repr((value.co_names, value.co_varnames, value.co_freevars)).encode())
        for constant in value.co_consts:
            _hash_value(digest, constant, seen)
    elif isinstance(value, np.ndarray):
        digest.update(repr((value.dtype, value.shape)).encode())
        digest.update(value.tobytes())
    elif isinstance(value, tuple):
        for entry in value:
            _hash_value(digest, entry, seen)
    elif isinstance(value, ModuleType):
        digest.update(value.__name__.encode())
    else:  # numbers and strings by value
        digest.update(repr(value).encode())


def _of_library(value: Any) -> bool:
    """Whether this is a function of NumPy's, say, known well enough by its name."""
    return hasattr(value, '__qualname__') and _is_library(getattr(value, '__module__', None) or '')


def _is_library(module: str) -> bool:
    return module.split('.')[0] in ('numpy', 'math', 'scipy', 'builtins')
