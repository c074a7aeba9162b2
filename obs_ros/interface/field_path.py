"""Paths to one number in a message: `position[shoulder]`, `pose.pose.position.x`, `data[2]`.

After a geometry_msgs/Quaternion they may go on with `roll`, `pitch` or `yaw`. They are split and
followed step by step, never evaluated. A message is anything with attributes, so that messages of
rclpy and those read from a bag will both do.
"""

import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from numbers import Real
from typing import Any, Literal

import numpy as np

from obs_ros.core.registry import suggest
from obs_ros.core.texts import quoted
from obs_ros.interface.quaternion import ANGLES, TYPES, angle_of, is_quaternion, turn

# Fields beside an array that name its entries: there `[label]` is looked up.
LABELS = ('name', 'names', 'joint_names')
NUMBERS = frozenset(
    {'boolean', 'float', 'double', 'long double', 'char', 'uint8'}
    | {f'{sign}int{bits}' for sign in ('', 'u') for bits in (8, 16, 32, 64)}
)
FieldsOf = Callable[[str], Mapping[str, str]]
LONGEST = 500  # characters of a path, which is matched step by step

_STEP = re.compile(r'(?P<field>[a-zA-Z][a-zA-Z0-9_]*)(?:\[(?P<key>[^\[\]]+)\])?')
_ARRAY = re.compile(r'sequence<(?P<of>.+?)(?:, *\d+)?>|(?P<item>.+)\[(?P<size>\d+)\]')
_MESSAGE = re.compile(r'[a-zA-Z][a-zA-Z0-9_]*(?:/msg)?/[A-Z][a-zA-Z0-9]*')


Reason = Literal[
    'no_field', 'no_entry', 'not_a_number', 'not_a_rotation', 'wrong_length', 'unknown_name',
    'missing_name',
]  # fmt: skip


class MessageError(ValueError):
    """A message without the numbers that are read from it; refusals are counted by `reason`."""

    def __init__(self, reason: Reason, text: str) -> None:
        super().__init__(text)
        self.reason = reason


@dataclass(frozen=True)
class Step:
    """One field, and the entry of it that is meant: an index, a label, or None for the field."""

    field: str
    key: int | str | None = None

    def __str__(self) -> str:
        """Return the step as it is written."""
        return self.field if self.key is None else f'{self.field}[{self.key}]'


@dataclass(frozen=True)
class FieldPath:
    """Steps from a message to a number."""

    steps: tuple[Step, ...]

    @classmethod
    def parse(cls, text: str) -> 'FieldPath':
        """Read a path as it is written; raises ValueError where it is none."""
        if not text or len(text) > LONGEST:
            raise ValueError(f'a field path has 1 to {LONGEST} characters, not {len(text)}')
        if not text.isprintable():
            raise ValueError(f'a field path has printable characters, which {quoted(text)} has not')
        steps, position = [], 0
        while True:
            step = _STEP.match(text, position)
            if step is None:
                raise ValueError(
                    f'{quoted(text)} is not a field path like data[2], position[shoulder] or '
                    f'pose.position.x: no field can begin at {quoted(text[position:])}'
                )
            key = step['key']
            # isdecimal alone would take digits of other scripts.
            number = key is not None and key.isascii() and key.isdecimal()
            steps.append(Step(step['field'], int(key) if number else key))
            position = step.end()
            if position == len(text):
                return cls(tuple(steps))
            if text[position] != '.':
                raise ValueError(
                    f'{quoted(text)} is not a field path like data[2], position[shoulder] or '
                    f'pose.position.x: {quoted(text[position:])} cannot follow '
                    f'{quoted(text[:position])}'
                )
            position += 1

    def __str__(self) -> str:
        """Return the path as it is written."""
        return '.'.join(map(str, self.steps))

    def read(self, message: Any) -> float:
        """Return the number that a message holds there; booleans are 0 and 1.

        Raises MessageError, its reason one of `no_field`, `no_entry`, `not_a_number`, and
        `not_a_rotation` for a quaternion whose norm is far from 1.
        """
        value = message
        for step in self.steps:
            owner, value = value, _field(value, step)
            if step.key is not None:
                value = _entry(owner, value, step)
        if not isinstance(value, Real | np.bool_):
            raise MessageError('not_a_number', f'{self} is a {type(value).__name__}, not a number')
        return float(value)

    def write(self, message: Any, value: float) -> None:
        """Put a number there, where `read` will find it; arrays grow by NaN and names as needed.

        Integers take the nearest one. Raises MessageError where a message is missing on the way.
        """
        for step in self.steps[:-1]:
            owner, message = message, _field(message, step)
            if step.key is not None:
                message = _entry(owner, message, step)
        last = self.steps[-1]
        if _is_angle(message, last):
            turn(message, last.field, value)
            return
        old = _field(message, last)
        if last.key is None:
            setattr(
                message, last.field, type(old)(value if isinstance(old, float) else round(value))
            )
            return
        index = last.key if isinstance(last.key, int) else _labelled(message, last)
        whole = not isinstance(old, np.ndarray) and getattr(old, 'typecode', 'd') not in 'fd'
        while len(old) <= index:
            old.append(0 if whole else math.nan)
        old[index] = round(value) if whole else value

    def check(self, type_name: str, fields_of: FieldsOf) -> None:
        """Make sure that messages of a type have a number there, as far as the type shows.

        `fields_of` returns the fields of a message type with their types, as
        `get_fields_and_field_types` of its class does. Raises ValueError that names the nearest
        field.
        """
        for k, step in enumerate(self.steps):
            fields = _steps_from(type_name, fields_of)
            if step.field not in fields:
                hint = suggest(step.field, list(fields))
                if step.field in ANGLES:
                    hint = f'{", ".join(ANGLES)} follow a field of type {TYPES[0]}; {hint}'
                raise ValueError(f'{type_name} has no field {quoted(step.field)}: {hint}')
            type_name = fields[step.field]
            if step.key is not None:
                type_name = _entry_type(step, type_name, fields)
            if k + 1 < len(self.steps) and not _MESSAGE.fullmatch(type_name):
                raise ValueError(f'{self}: {step} is a {type_name} and has no fields')
        if type_name not in NUMBERS:
            raise ValueError(f'{self} is a {type_name}, not a number{_hint(type_name, fields_of)}')


def _field(message: Any, step: Step) -> Any:
    try:
        return getattr(message, step.field)
    except AttributeError:
        if _is_angle(message, step):
            try:
                return angle_of(message, step.field)
            except ValueError as error:
                raise MessageError('not_a_rotation', f'no {step.field}: {error}') from None
        kind = type(message).__name__
        raise MessageError('no_field', f'{kind} has no field {quoted(step.field)}') from None


def _is_angle(message: Any, step: Step) -> bool:
    """Whether a step asks for roll, pitch or yaw of a quaternion."""
    return step.key is None and step.field in ANGLES and is_quaternion(message)


def _steps_from(type_name: str, fields_of: FieldsOf) -> Mapping[str, str]:
    """Return the fields of a message type with their types, and what paths add to them."""
    fields = fields_of(type_name)
    return {**dict.fromkeys(ANGLES, 'double'), **fields} if type_name in TYPES else fields


def _entry(owner: Any, array: Any, step: Step) -> Any:
    """Return the entry of an array of `owner` that a step means."""
    index = step.key if isinstance(step.key, int) else _index(owner, step)
    if not hasattr(array, '__getitem__') or isinstance(array, str | bytes | Mapping):
        raise MessageError('no_entry', f'{step.field} is no array')
    if index >= len(array):
        raise MessageError('no_entry', f'{step.field} has {len(array)} entries, but not {step}')
    return array[index]


def _index(owner: Any, step: Step) -> int:
    for field in LABELS:
        labels: Sequence[str] | None = getattr(owner, field, None)
        if labels is not None and not isinstance(labels, str):
            for index, label in enumerate(labels):
                if label == step.key:
                    return index
            hint = suggest(str(step.key), [str(label) for label in labels])
            raise MessageError('no_entry', f'there is no {quoted(step.key)} in {field}: {hint}')
    raise MessageError('no_entry', f'{step}: no field {", ".join(LABELS)} names the entries')


def _labelled(owner: Any, step: Step) -> int:
    """Return the index of a label, written down where it is not among the labels yet."""
    labels: list[str] = next(getattr(owner, field) for field in LABELS if hasattr(owner, field))
    if step.key not in labels:
        labels.append(str(step.key))
    return labels.index(str(step.key))


def _entry_type(step: Step, type_name: str, fields: Mapping[str, str]) -> str:
    """Return the type of an array's entries; raises ValueError where there can be no such entry."""
    array = _ARRAY.fullmatch(type_name)
    if array is None:
        raise ValueError(f'{step}: {step.field} is a {type_name}, not an array')
    size = float(array['size'] or math.inf)
    if isinstance(step.key, int) and step.key >= size:
        raise ValueError(f'{step}: {step.field} has {size:.0f} entries, the first of them [0]')
    if isinstance(step.key, str) and not any(
        fields.get(field, '').startswith(('sequence<string', 'string[')) for field in LABELS
    ):
        raise ValueError(
            f'{step}: an entry can be named only where a field {" or ".join(LABELS)} beside it '
            f'holds the names; give its number, as in {step.field}[0]'
        )
    return array['of'] or array['item']


def _hint(type_name: str, fields_of: FieldsOf) -> str:
    """Say how the path can go on from a type that is not a number."""
    if _ARRAY.fullmatch(type_name):
        return ': say which entry, as in [0] or [name]'
    if _MESSAGE.fullmatch(type_name):
        return f': go on with one of its fields {", ".join(_steps_from(type_name, fields_of))}'
    return ''
