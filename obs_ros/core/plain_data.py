"""Frozen data as plain numbers, texts and lists, as JSON has them, and back with the same bits.

The types of the fields say what stands where: nothing that is read names a class, or is run. A
number that JSON does not have is a text, `nan`, `inf` or `-inf`. An array is its shape and its
float64 in base64: exact, and a fiftieth of the time that digits take.
"""

import base64
import binascii
import dataclasses
import functools
import math
import types
import typing
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any

import numpy as np

from obs_ros.core.texts import quoted

BITS = '<f8'
NOT_FINITE = {'nan': math.nan, 'inf': math.inf, '-inf': -math.inf}


def to_plain(value: Any) -> Any:
    """Return what `from_plain` reads: dicts, lists, texts, integers, finite floats, None.

    Raises TypeError for what it does not know.
    """
    if value is None or isinstance(value, bool | int):
        return value
    if isinstance(value, str):
        return str(value)
    if isinstance(value, float):
        number = float(value)
        return number if math.isfinite(number) else str(number)
    if isinstance(value, np.ndarray):
        bits = base64.b64encode(np.ascontiguousarray(value, dtype=BITS).tobytes())
        return {'shape': list(value.shape), 'float64': bits.decode()}
    kind: Any = type(value)
    if (names := _field_names(kind)) is not None:
        return {name: to_plain(getattr(value, name)) for name in names}
    if isinstance(value, frozenset):
        return [to_plain(each) for each in sorted(value)]
    if isinstance(value, tuple | list):
        return [to_plain(each) for each in value]
    if isinstance(value, Mapping):
        return [[to_plain(key), to_plain(each)] for key, each in value.items()]
    raise TypeError(f'{type(value).__name__} cannot be written as plain data')


@dataclass(frozen=True)
class Shapes:
    """Shapes of arrays by `Class.field`, such as `q q`, and who may hold what is not finite.

    `sizes` gives the lengths that are known, by letter; any other letter has one length in all
    fields of an object. `not_finite` names fields, arrays or numbers, with NaN or infinities.
    """

    shapes: Mapping[str, str] = field(default_factory=dict)
    sizes: Mapping[str, int] = field(default_factory=dict)
    not_finite: frozenset[str] = frozenset()


def from_plain(kind: Any, plain: Any, shapes: Shapes, path: str = '') -> Any:
    """Return the object of a type that plain data stand for.

    Raises ValueError, with the path to it, for what is of another type or shape, is missing or too
    much, and for a number that is not finite where none may be.
    """
    return _Reader(shapes).read(kind, plain, path)


@dataclass
class _Reader:
    """Reads one value after the other: `place` is its field, `lengths` are those of its object."""

    shapes: Shapes
    place: str = ''
    lengths: dict[str, int] = field(default_factory=dict)

    def read(self, kind: Any, plain: Any, path: str) -> Any:
        if kind in (bool, int, str, type(None)):
            return plain if type(plain) is kind else _refuse(path, _WORDS[kind], plain)
        if kind is float:
            return self._number(plain, path)
        if isinstance(kind, type) and issubclass(kind, StrEnum):
            return kind(plain) if plain in list(kind) else _refuse(path, ' or '.join(kind), plain)
        if typing.get_origin(kind) is np.ndarray:
            return self._array(plain, path)
        if isinstance(kind, type) and _field_names(kind) is not None:
            return self._object(kind, plain, path)
        return self._collection(kind, plain, path)

    def _number(self, plain: Any, path: str) -> float:
        if type(plain) is str and plain in NOT_FINITE and self._may_be_any:
            return NOT_FINITE[plain]
        return plain if type(plain) is float and math.isfinite(plain) else _refuse(
            path, 'a finite number', plain
        )  # fmt: skip

    def _array(self, plain: Any, path: str) -> Any:
        letters = self.shapes.shapes[self.place].split()
        if not isinstance(plain, dict) or plain.keys() != {'shape', 'float64'}:
            return _refuse(path, 'an array', plain)
        shape, bits = plain['shape'], plain['float64']
        if not isinstance(shape, list) or len(shape) != len(letters):
            return _refuse(path, f'an array of {len(letters)} dimensions', shape)
        for letter, length in zip(letters, shape, strict=True):
            known = self.shapes.sizes.get(letter)
            known = self.lengths.setdefault(letter, length) if known is None else known
            if type(length) is not int or length < 0 or length != known:
                return _refuse(path, f'an array of {known} as its {letter}', shape)
        try:
            raw = base64.b64decode(bits, validate=True)
        except (TypeError, ValueError, binascii.Error):
            return _refuse(path, 'base64', bits)
        if len(raw) != 8 * math.prod(shape):
            return _refuse(path, f'{8 * math.prod(shape)} bytes', len(raw))
        array = np.frombuffer(raw, dtype=BITS).astype(np.float64).reshape(shape)
        if not (self._may_be_any or np.isfinite(array).all()):
            return _refuse(path, 'finite numbers', 'NaN or infinity')
        return array

    def _object(self, kind: Any, plain: Any, path: str) -> Any:
        names = _field_names(kind)
        if not isinstance(plain, dict) or plain.keys() != set(names or ()):
            return _refuse(path, f'an object with {", ".join(names or ())}', plain)
        hints, read = _hints(kind), {}
        inner = _Reader(self.shapes)
        for name, each in plain.items():
            inner.place = f'{kind.__name__.lstrip("_")}.{name}'
            read[name] = inner.read(hints[name], each, f'{path}.{name}'.lstrip('.'))
        return kind(**read)

    def _collection(self, kind: Any, plain: Any, path: str) -> Any:
        origin, arguments = typing.get_origin(kind), typing.get_args(kind)
        if origin in (typing.Union, types.UnionType):  # something, or None
            some = next(each for each in arguments if each is not type(None))
            return None if plain is None else self.read(some, plain, path)
        if not isinstance(plain, list):
            return _refuse(path, 'a list', plain)
        if origin in (frozenset, list, Mapping) or arguments[1:] == (...,):
            item: Any = types.GenericAlias(tuple, arguments) if origin is Mapping else arguments[0]
            read = [self.read(item, each, f'{path}[{i}]') for i, each in enumerate(plain)]
            made: Any = dict(read) if origin is Mapping else origin(read)
            return made if len(made) == len(read) else _refuse(path, 'no entry twice', plain)
        if len(plain) != len(arguments):
            return _refuse(path, f'{len(arguments)} entries', plain)
        return tuple(
            self.read(each, value, f'{path}[{i}]')
            for i, (each, value) in enumerate(zip(arguments, plain, strict=True))
        )

    @property
    def _may_be_any(self) -> bool:
        return self.place in self.shapes.not_finite


_WORDS = {bool: 'true or false', int: 'an integer', str: 'a text', type(None): 'null'}


def _refuse(path: str, wanted: str, found: Any) -> Any:
    raise ValueError(f'{path or "the whole"} must be {wanted}, not {quoted(found)}')


@functools.cache
def _field_names(kind: Any) -> tuple[str, ...] | None:
    """Return the fields of a dataclass or a named tuple; None for any other type."""
    if dataclasses.is_dataclass(kind):
        return tuple(each.name for each in dataclasses.fields(kind))
    names: tuple[str, ...] | None = getattr(kind, '_fields', None)
    return names


@functools.cache
def _hints(kind: Any) -> dict[str, Any]:
    return typing.get_type_hints(kind)


def described(kind: Any) -> str:
    """Return the layout of the data of a type: its fields and their types, to any depth."""
    seen: dict[str, str] = {}

    def note(each: Any) -> None:
        for argument in typing.get_args(each):
            note(argument)
        if (names := _field_names(each)) is None or each.__name__ in seen:
            return
        hints = _hints(each)
        seen[each.__name__] = ', '.join(f'{name}: {_words(hints[name])}' for name in names)
        for name in names:
            note(hints[name])

    note(kind)
    return '\n'.join(f'{name}({fields})' for name, fields in sorted(seen.items()))


def _words(kind: Any) -> str:
    """Return the name of a type, whatever version of NumPy or Python writes it."""
    if typing.get_origin(kind) is np.ndarray:
        return 'Array'
    arguments = typing.get_args(kind)
    if not arguments:
        return getattr(kind, '__name__', str(kind))
    origin = typing.get_origin(kind)
    name = 'Union' if origin in (typing.Union, types.UnionType) else origin.__name__
    return f'{name}[{", ".join("..." if each is ... else _words(each) for each in arguments)}]'
