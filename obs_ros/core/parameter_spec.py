"""One row of a node's table of parameters: its type, range and description. Knows no ROS."""

import contextlib
import math
import re
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from obs_ros.core.registry import meant, suggest
from obs_ros.core.texts import listing, quoted

MOST_ENTRIES = 1000  # of an array, so that no remote value fills the memory
LARGEST_INTEGER = 2**63  # as ROS has them
YAML_WORDS = {False: ('off', 'no'), True: ('on', 'yes')}  # YAML 1.1
LARGEST_SEED = 2**31 - 1  # as ROS command lines take integers

Value = bool | int | float | str | tuple[float, ...] | tuple[str, ...]

_WORDS = {bool: 'true or false', int: 'an integer', float: 'a number', str: 'text'}


@dataclass(frozen=True)
class ParameterSpec:
    """One parameter: its `default` gives the type; a tuple stands for an array.

    `lower` and `upper` bound numbers and the entries of arrays, `positive` excludes 0 as well,
    `infinite` allows infinity beside the numbers up to a finite `upper`, as `nan` allows NaN.
    `choices` lists the words allowed, `length` fixes an array's. `or_pair` lets two numbers stand
    in place of one. `read_only` ones are set at start only.
    """

    name: str
    default: Value
    description: str
    unit: str = ''
    lower: float = -math.inf
    upper: float = math.inf
    positive: bool = False
    nan: bool = False
    infinite: bool = False
    choices: tuple[str, ...] = ()
    length: int | None = None
    or_pair: bool = False
    read_only: bool = False

    @property
    def range(self) -> str:
        """The values allowed, in words."""
        if self.choices:
            return ' | '.join(choice or "''" for choice in self.choices)
        if isinstance(self._entry, bool | str):
            return ''
        if self.positive:
            return '> 0' if math.isinf(self.upper) else f'> 0, <= {_figure(self.upper)}'
        if math.isinf(self.upper):
            return '' if math.isinf(self.lower) else f'>= {_figure(self.lower)}'
        or_infinite = ', or inf' if self.infinite else ''
        return f'{_figure(self.lower)} to {_figure(self.upper)}{or_infinite}'

    def coerce(self, value: Any) -> Value:
        """Return `value` as the parameter's type: integers pass where floats are meant.

        Raises ValueError saying what is wrong and what is allowed.
        """
        typed: Value = self.typed(value)
        if isinstance(typed, tuple):
            length = 2 if self.or_pair else self.length
            if length is not None and len(typed) != length:
                raise ValueError(f'{self.name} must have {length} entries, not {len(typed)}')
            if len(typed) > MOST_ENTRIES:
                raise ValueError(
                    f'{self.name} must have at most {MOST_ENTRIES} entries, not {len(typed)}'
                )
            for entry in typed:
                self._check_number(entry)
        elif self.choices and typed not in self.choices:
            known = [choice for choice in self.choices if choice]
            raise ValueError(f'unknown {self.name} {quoted(typed)}: {suggest(str(typed), known)}')
        else:
            self._check_number(typed)
        return typed

    def typed(self, value: Any) -> Value:
        """Return `value` as the parameter's type, its range unchecked; raises ValueError."""
        if isinstance(value, bool):  # as YAML, and so ROS, reads these words without quotes
            value = next((word for word in YAML_WORDS[value] if word in self.choices), value)
        entry = self._entry
        several = isinstance(value, Iterable) and not isinstance(value, str | bytes)
        if not (several and self.or_pair) and not self._is_array:
            return _as_type(self.name, type(entry), value)  # type: ignore[no-any-return]
        if not several:
            raise ValueError(
                f'{self.name} must be an array like {plain(self.default)}, not {quoted(value)}'
            )
        return tuple(_as_type(self.name, type(entry), each) for each in value)

    def describe(self) -> str:
        """Return the description with unit, range and when it can be set."""
        notes = [
            f'in {self.unit}' if self._has_unit else '',
            self.range,
            'at start only' if self.read_only else '',
        ]
        text = '; '.join(note for note in notes if note)
        return self.description + (f' ({text})' if text else '')

    @property
    def _is_array(self) -> bool:
        """Whether a single value is none: an array is meant."""
        return isinstance(self.default, tuple) and not self.or_pair

    @property
    def _entry(self) -> bool | int | float | str:
        """The default, or the first entry of one that is an array."""
        return self.default[0] if isinstance(self.default, tuple) else self.default

    @property
    def _has_unit(self) -> bool:
        return self.unit not in ('', '1')

    def _check_number(self, value: bool | float | str) -> None:
        """Raise ValueError for a number that is out of range."""
        if not isinstance(value, bool | str) and not self._allows(value):
            unit = f' {self.unit}' if self._has_unit else ''
            raise ValueError(f'{self.name} must be {self.range or "a number"}{unit}, not {value}')

    def _allows(self, value: float) -> bool:
        if math.isnan(value):
            return self.nan
        if self.infinite and value == math.inf:
            return True
        return self.lower <= value <= self.upper and (value > 0 or not self.positive)


def check_names(given: Iterable[str], renamed: Mapping[str, str]) -> None:
    """Raise ValueError for a name by which a parameter was called once, naming the new one."""
    for name in given:
        if name in renamed:
            raise ValueError(f'{name} is now {renamed[name]}: give that one')


def ignored(names: Collection[str], known: Collection[str]) -> str:
    """Say in one line which of the names given mean nothing, and what may be meant instead."""
    hints = (f'{quoted(name)} ({meant(name, known)})'.replace(' ()', '') for name in sorted(names))
    return f'ignored, as there are no such parameters: {listing(list(hints))}'


def markdown_table(specs: Iterable[ParameterSpec]) -> str:
    """Return the parameters as a Markdown table, for the README."""
    rows = ['| parameter | default | meaning |', '|---|---|---|']
    for spec in specs:
        default = plain(spec.default)
        text = str(default).lower() if isinstance(default, bool) else str(default)
        meaning = spec.describe().replace('|', '\\|')
        rows.append(f'| `{spec.name}` | {f"`{text}`" if text else ""} | {meaning} |')
    return '\n'.join(rows) + '\n'


def plain(value: Value) -> Any:
    """Return the value as ROS takes it: arrays are lists there."""
    return list(value) if isinstance(value, tuple) else value


def _figure(value: float) -> str:
    """Return a limit as people write it."""
    return str(value) if isinstance(value, int) else re.sub(r'e\+0*', 'e', f'{value:g}')


def _as_type(name: str, kind: type, value: Any) -> Any:
    if kind is float and isinstance(value, int) and not isinstance(value, bool):
        with contextlib.suppress(OverflowError):
            return float(value)
    if kind is int and type(value) is int and abs(value) >= LARGEST_INTEGER:
        raise ValueError(f'{name} must be an integer of 64 bits')
    if type(value) is not kind:
        raise ValueError(f'{name} must be {_WORDS[kind]}, not {quoted(value)}')
    return value
