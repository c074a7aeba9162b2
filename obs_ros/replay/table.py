"""A table of text, one row for each time: comma, semicolon or tab between the columns."""

import csv
import math
from codecs import BOM_UTF8
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from decimal import Decimal
from pathlib import Path
from typing import BinaryIO

import numpy as np

from obs_ros.core.model import Model, names
from obs_ros.core.record import Sample
from obs_ros.core.registry import suggest
from obs_ros.core.texts import listing, quoted
from obs_ros.core.typing import Array

# Time in a ROS stamp is int32 seconds.
LAST_STAMP = 2**31 * 10**9 - 1  # ns
LONGEST_ROW = 65536  # bytes
DELIMITERS = ',;\t'
TIMES = ('t', 'time', 'stamp')
UNITS = {'': 10**9, '_s': 10**9, '_ms': 10**6, '_us': 10**3, '_ns': 1}  # ns
TIME_UNITS = {name + suffix: unit for name in TIMES for suffix, unit in UNITS.items()}


class Table:
    """Samples out of a table whose first row names the columns.

    A column called t, time or stamp holds the time in s, or in the unit at the end of its name:
    t_ms, time_us, stamp_ns. Without one, the rows are `period` s apart, the first at 0. The other
    columns are called as the model's inputs and outputs are. `columns` gives them other names;
    there, `t` is the time, and an input and an output of one name are `input.<name>` and
    `output.<name>`. An empty field and nan stand for what was not measured; columns that the model
    does not know are left alone. The input of a row comes as a sample before that of its output.

    Raises ValueError, with file and line, for a head that does not suit.
    """

    def __init__(
        self, path: Path, columns: Mapping[str, str], period: float | None, model: Model
    ) -> None:
        self.refused: Counter[str] = Counter()
        self.done = 0.0
        self._path = path
        header, self._delimiter = read_header(path)
        try:
            self._time, self._inputs, self._outputs = _places(header, dict(columns), model)
            if period is not None:
                _check_period(period, None if self._time is None else header[self._time])
            elif self._time is None:
                raise ValueError(
                    f'no column is called {", ".join(TIMES)} (in s) or {TIMES[0]}_ns: name it '
                    'with --column t=NAME, or give the time from row to row with --period'
                )
        except ValueError as error:
            raise ValueError(f'{path}:1: {error}') from error
        self._period = None if period is None else Decimal(repr(period)) * 10**9
        self._unit = UNITS[''] if self._time is None else _unit(header[self._time])
        self._width = len(header)
        used = {self._time, *self._inputs, *self._outputs}
        unused = [name for place, name in enumerate(header) if place not in used]
        self.remarks: Sequence[str] = (
            [f'columns that the model does not know: {listing(unused)}'] if unused else []
        )

    def __iter__(self) -> Iterator[Sample]:
        """Yield the samples row by row; raises ValueError, with file and line, at a wrong one."""
        size = max(1, self._path.stat().st_size)
        with self._path.open('rb') as file:
            rows = _rows(file, self._path)
            next(rows)
            for index, (line, row) in enumerate(rows):
                self.done = min(1.0, file.tell() / size)
                try:
                    fields = _fields(_text(row), self._delimiter)
                    if len(fields) != self._width:
                        raise ValueError(f'{len(fields)} fields, but {self._width} columns')
                    stamp = self._stamp(index, fields)
                    u, y = _values(fields, self._inputs), _values(fields, self._outputs)
                except (ValueError, csv.Error) as error:
                    raise ValueError(f'{self._path}:{line}: {error}') from error
                if u.size and not np.isnan(u).all():
                    yield Sample(stamp, u=u)
                if not np.isnan(y).all():
                    yield Sample(stamp, y=y)

    def _stamp(self, index: int, fields: Sequence[str]) -> int:
        """Return the stamp (ns) of a row; decimals of a time since 1970 are beyond a float."""
        if self._time is None:
            assert self._period is not None
            time, unit = index * self._period, 1
        else:
            text, unit = fields[self._time].strip(), self._unit
            if not math.isfinite(_number(text)):
                raise ValueError(f'the time is {quoted(text)}, not a number')
            time = Decimal(text)
        if not 0 <= time * unit <= LAST_STAMP:
            raise ValueError(
                f'the time {time:g} is outside what a ROS stamp can be, 0 to {LAST_STAMP / unit:g}'
            )
        return round(time * unit)


def read_header(path: Path) -> tuple[list[str], str]:
    """Return the names of a table's columns, and the character between them.

    Raises ValueError, with file and line, for a first row that cannot be read.
    """
    with path.open('rb') as file:
        _, head = next(_rows(file, path), (0, b''))
    try:
        text = _text(head.removeprefix(BOM_UTF8))
        delimiter = max(DELIMITERS, key=text.count)
        return [name.strip() for name in _fields(text, delimiter)], delimiter
    except (ValueError, csv.Error) as error:
        raise ValueError(f'{path}:1: {error}') from error


def _rows(file: BinaryIO, path: Path) -> Iterator[tuple[int, bytes]]:
    """Yield line numbers and rows of a bounded length; blank ones and those after # are skipped."""
    line = 0
    while row := file.readline(LONGEST_ROW + 1):
        line += 1
        if len(row) > LONGEST_ROW:
            raise ValueError(f'{path}:{line}: the row is longer than {LONGEST_ROW} bytes')
        if (stripped := row.strip(b'\r\n')) and not row.startswith(b'#'):
            yield line, stripped


def _text(row: bytes) -> str:
    try:
        return row.decode()
    except UnicodeDecodeError as error:
        raise ValueError(
            f'save the table as UTF-8: byte {row[error.start]:#04x} is of another encoding'
        ) from error


def _fields(row: str, delimiter: str) -> list[str]:
    if '"' not in row:
        return row.split(delimiter)
    return next(csv.reader([row], delimiter=delimiter, strict=True))


def _places(
    header: Sequence[str], columns: dict[str, str], model: Model
) -> tuple[int | None, list[int], list[int]]:
    """Return where the time (None: nowhere), the inputs and the outputs stand in a row."""
    twice = [name for name, count in Counter(header).items() if count > 1]
    if twice:
        raise ValueError(f'more than one column is called {quoted(twice[0])}')
    time = columns.pop('t', None)
    if time is None:
        found = [name for name in header if name in TIME_UNITS]
        if len(found) > 1:
            raise ValueError(
                f'{quoted(found[0])} and {quoted(found[1])} may both be the time: '
                'say which with --column t='
            )
        time = found[0] if found else None
    groups = [('input', names(model.inputs)), ('output', names(model.outputs))]
    known = [name for kind, group in groups for each in group for name in (each, f'{kind}.{each}')]
    for name in columns:
        if name not in known:
            raise ValueError(f'--column {name}=: the model has no such input or output: '
                             f'{suggest(name, known)}')  # fmt: skip
    wanted = [
        [columns.get(f'{kind}.{name}', columns.get(name, name)) for name in group]
        for kind, group in groups
    ]
    flat = [*([time] if time is not None else []), *wanted[0], *wanted[1]]
    for name in flat:
        if name not in header:
            raise ValueError(f'no column is called {quoted(name)}: {suggest(name, list(header))}; '
                             'other names are given with --column NAME=COLUMN')  # fmt: skip
        if flat.count(name) > 1:
            raise ValueError(f'the column {quoted(name)} is wanted twice: say with --column '
                             'input.NAME= and output.NAME= which is which')  # fmt: skip
    inputs, outputs = ([header.index(name) for name in group] for group in wanted)
    return None if time is None else header.index(time), inputs, outputs


def _unit(name: str) -> int:
    """Return the ns in one of what the time column counts, by the end of its name."""
    _, separator, suffix = name.rpartition('_')
    return UNITS.get(separator + suffix, UNITS[''])


def _check_period(period: float, time: str | None) -> None:
    if time is not None:
        raise ValueError(f'the column {quoted(time)} tells the time already: no --period is needed')
    if not 1e-9 <= period <= 1e9:
        raise ValueError(f'the period {period} s is not a time between 1e-9 and 1e9 s')


def _values(fields: Sequence[str], places: Sequence[int]) -> Array:
    return np.array([_number(fields[place].strip()) for place in places], dtype=np.float64)


def _number(text: str) -> float:
    """Return the number, NaN for an empty field; raises ValueError for other text."""
    if not text:
        return math.nan
    try:
        if '_' in text:
            raise ValueError
        return float(text)
    except ValueError:
        raise ValueError(f'{quoted(text, 40)} is not a number') from None
