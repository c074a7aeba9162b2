"""Fingerprints of functions: hashes of all that their compiled code depends on."""

import dis
import functools
import hashlib
from collections.abc import Callable, Iterable, Iterator
from types import CodeType, FunctionType, ModuleType
from typing import Any

import numpy as np

_KINDS = {'LOAD_GLOBAL': 0, 'LOAD_NAME': 0, 'LOAD_ATTR': 1, 'LOAD_METHOD': 1}


def fingerprint(text: str, *functions: Callable[..., Any]) -> str:
    """Hash a text and functions: their code, constants, and the globals they use, to any depth.

    The names of the functions' modules count too, since compiled code looks these modules up.
    """
    digest = hashlib.sha256(text.encode())
    seen: set[int] = set()
    for function in functions:
        _hash_value(digest, function, seen)
    return digest.hexdigest()[:24]


def used_globals(function: FunctionType) -> Iterator[tuple[str, Any]]:
    """Yield name and value of every global that the function reads, in the names' order."""
    for name in _names(function.__code__)[0]:
        if name in function.__globals__:
            yield name, function.__globals__[name]


def used_attributes(function: FunctionType) -> tuple[str, ...]:
    """Return the names of all attributes that the function reads, of whatever, in order."""
    return _names(function.__code__)[1]


def loaded(function: FunctionType) -> Iterator[Any]:
    """Yield the globals that the function reads, and the attributes that it reads of them."""
    steps = list(dis.get_instructions(function.__code__))
    for step, following in zip(steps, [*steps[1:], None], strict=True):
        if step.opname == 'LOAD_GLOBAL' and step.argval in function.__globals__:
            value = function.__globals__[step.argval]
            yield value
            if following is not None and following.opname in ('LOAD_ATTR', 'LOAD_METHOD'):
                yield getattr(value, following.argval, None)


def of_library(value: Any) -> bool:
    """Whether this is a function or module of NumPy, say, known well enough by its name."""
    if isinstance(value, ModuleType):
        return _is_library(value.__name__)
    return hasattr(value, '__qualname__') and _is_library(getattr(value, '__module__', None) or '')


def _is_library(module: str) -> bool:
    return module.split('.')[0] in ('numpy', 'math', 'scipy', 'builtins')


@functools.lru_cache(maxsize=4096)  # several functions that are compiled call the same ones
def _names(code: CodeType) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return the names that the code, and functions inside it, read as globals and attributes."""
    codes, found = [code], (set[str](), set[str]())
    for each in codes:
        for step in dis.get_instructions(each):
            if (kind := _KINDS.get(step.opname)) is not None:
                found[kind].add(step.argval)
        codes += [constant for constant in each.co_consts if isinstance(constant, CodeType)]
    return tuple(sorted(found[0])), tuple(sorted(found[1]))


def _hash_value(digest: Any, value: Any, seen: set[int]) -> None:
    value = getattr(value, 'py_func', value)  # a function that is compiled already
    if of_library(value):
        digest.update(f'{value.__module__}.{value.__qualname__}'.encode())
    elif isinstance(value, FunctionType):
        _hash_function(digest, value, seen)
    elif isinstance(value, CodeType):
        digest.update(value.co_code)
        names = value.co_names, value.co_varnames, value.co_freevars, value.co_kwonlyargcount
        digest.update(repr(names).encode())
        for constant in value.co_consts:
            _hash_value(digest, constant, seen)
    elif isinstance(value, np.ndarray):
        digest.update(repr((value.dtype, value.shape)).encode())
        digest.update(value.tobytes())
    elif isinstance(value, (tuple, list)):
        digest.update(f'{type(value).__qualname__} of {len(value)}'.encode())
        for entry in value:
            _hash_value(digest, entry, seen)
    elif isinstance(value, type):
        digest.update(f'{value!r} {getattr(value, "_fields", "")}'.encode())
    else:  # numbers and strings by value
        digest.update(repr(value).encode())


def _hash_function(digest: Any, function: FunctionType, seen: set[int]) -> None:
    if id(function) in seen:
        return
    seen.add(id(function))
    digest.update(f'{function.__module__}.{function.__qualname__}'.encode())
    _hash_value(digest, function.__code__, seen)
    for kind in function.__annotations__.values():
        _hash_layout(digest, kind)
    _hash_value(digest, function.__defaults__, seen)
    _hash_value(digest, sorted((function.__kwdefaults__ or {}).items()), seen)
    attributes = used_attributes(function)
    cells = (('', cell.cell_contents) for cell in function.__closure__ or ())
    for name, used in (*used_globals(function), *cells):
        digest.update(name.encode())
        if isinstance(used, ModuleType):
            _hash_module(digest, used, attributes, seen)
        else:
            _hash_value(digest, used, seen)


def _hash_layout(digest: Any, kind: Any) -> None:
    """Hash a named tuple's fields: compiled code knows them by their places."""
    if hasattr(kind, '_fields'):
        digest.update(f'{kind!r} {kind._fields}'.encode())
        for inner in getattr(kind, '__annotations__', {}).values():
            _hash_layout(digest, inner)


def _hash_module(
    digest: Any, module: ModuleType, attributes: Iterable[str], seen: set[int]
) -> None:
    """Hash what a function may use of a module, or of modules inside it, by these names."""
    reached = [module]
    for inner in reached:
        digest.update(inner.__name__.encode())
        if of_library(inner):
            continue
        for attribute in attributes:
            used = getattr(inner, attribute, None)
            if not isinstance(used, ModuleType):
                _hash_value(digest, used, seen)
            elif used not in reached:
                reached.append(used)
