"""Names and units of the signals of a plant, from the command line or the header of a table."""

import keyword
import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from obs_ros.core.registry import suggest
from obs_ros.core.texts import listing, quoted
from obs_ros.replay.table import TIME_UNITS

LONGEST_NAME, LONGEST_UNIT = 40, 20  # characters
MOST_PARAMETERS = 60  # of the first guess: a rest and a lag for each output, a gain for each pair
PLAIN_NAME = re.compile(r'[A-Za-z_][A-Za-z0-9_]*', re.ASCII)
WITH_UNIT = re.compile(r'(?P<name>.*?)\s*[\[(](?P<unit>[^\[\]()]*)[\])]', re.DOTALL)


@dataclass(frozen=True)
class Signal:
    """One input or output: its name, its unit, and its column in a table (empty: no table)."""

    name: str
    unit: str = '1'
    column: str = ''


@dataclass(frozen=True)
class Signals:
    """The inputs and outputs of a plant; `time` is the time column, where it has another name.

    Raises ValueError for names that a model of them cannot have.
    """

    inputs: tuple[Signal, ...]
    outputs: tuple[Signal, ...]
    time: str = ''

    def __post_init__(self) -> None:
        for signal in (*self.inputs, *self.outputs):
            check_name(signal.name)
            _check_unit(signal)
        if not self.outputs:
            raise ValueError('name at least one output with --output NAME=UNIT: there is none')
        if any(signal.name == 'u' for signal in self.outputs):
            raise ValueError(
                "give output 'u' another name (of a column: --output y --column y=u): the "
                'functions of a model call their inputs so'
            )
        count = len(self.outputs) * (len(self.inputs) + 2)
        if count > MOST_PARAMETERS:
            raise ValueError(
                f'name with --input and --output only those that matter: {len(self.inputs)} '
                f'inputs and {len(self.outputs)} outputs make {count} parameters, at most '
                f'{MOST_PARAMETERS}'
            )
        known = [signal.name for signal in (*self.inputs, *self.outputs)]
        for name, times in Counter([*known, *self.parameters]).items():
            if times > 1 and known.count(name) > 1:
                raise ValueError(f'name each signal once: {quoted(name)} is there more than once')
            if times > 1:
                raise ValueError(
                    'give one of the signals another name: the first guess would have more than '
                    f'one variable {quoted(name)}'
                )

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of the first guess's parameters: for each output its rest, gains and lag."""
        return tuple(
            name
            for output in self.outputs
            for name in (
                f'rest_{output.name}',
                *(f'gain_{output.name}_{each.name}' for each in self.inputs),
                f'lag_{output.name}',
            )
        )

    @property
    def columns(self) -> dict[str, str]:
        """Columns of a table by the names that they have in the model, where these differ."""
        renamed = {'t': self.time} if self.time else {}
        for signal in (*self.inputs, *self.outputs):
            if signal.column not in ('', signal.name):
                renamed[signal.name] = signal.column
        return renamed


def check_name(name: str) -> None:
    """Raise ValueError for what cannot be a variable in Python, in ASCII, and short."""
    fits = PLAIN_NAME.fullmatch(name) and len(name) <= LONGEST_NAME
    if not fits or keyword.iskeyword(name):
        word = 'is a word of Python' if keyword.iskeyword(name) else 'is none'
        raise ValueError(
            f'give a name of letters, digits and _ (at most {LONGEST_NAME} characters, not '
            f'beginning with a digit): {quoted(name)} {word}; a column is renamed with --column '
            f'{proposed_name(name)}={quoted(name)}'
        )


def proposed_name(text: str) -> str:
    """Return a name made of what a text has of letters and digits."""
    words = re.findall(r'[a-z0-9]+', text.lower())
    name = '_'.join(words)[: LONGEST_NAME - 1].strip('_') or 'signal'
    return f'_{name}' if name[0].isdigit() else f'{name}_' if keyword.iskeyword(name) else name


def named(option: str, text: str) -> Signal:
    """Return the signal of NAME or NAME=UNIT; raises ValueError for an empty part."""
    name, separator, unit = text.partition('=')
    if not name or (separator and not unit):
        raise ValueError(f'{option} must be NAME or NAME=UNIT, not {quoted(text)}')
    return Signal(name, unit or '1')


def of_names(inputs: Sequence[Signal], outputs: Sequence[Signal]) -> Signals:
    """Return the signals of a plant without a table."""
    return Signals(tuple(inputs), tuple(outputs))


def of_header(
    header: Sequence[str],
    columns: Mapping[str, str],
    inputs: Sequence[Signal],
    outputs: Sequence[Signal],
) -> Signals:
    """Return the signals of a table with the columns `header`.

    A column may have its unit in brackets behind the name; `columns` names others. Of inputs and
    outputs the kind that is not named has all columns that are left.

    Raises ValueError where a column is missing, is there twice, or where none is named.
    """
    twice = [name for name, count in Counter(header).items() if count > 1]
    if twice:
        raise ValueError(f'name each column once: more than one is called {quoted(twice[0])}')
    own = {name: column for name, column in columns.items() if name != 't'}
    time = columns.get('t', '')
    for column in columns.values():
        if column not in header:
            raise ValueError(f'--column: there is no column {quoted(column)}: '
                             f'{suggest(column, list(header))}')  # fmt: skip
    timed = time or next((name for name in header if name in TIME_UNITS), '')
    by_column = {column: name for name, column in own.items()}
    offered = [_signal(column, by_column.get(column)) for column in header if column != timed]
    if not (inputs or outputs):
        raise ValueError(
            'say which columns are inputs: --input NAME=UNIT for each, all others are outputs; '
            f'there are {listing([each.name for each in offered]) or "none but the time"}'
        )
    found = {
        '--input': [_chosen('--input', each, offered) for each in inputs],
        '--output': [_chosen('--output', each, offered) for each in outputs],
    }
    taken = {signal.column for group in found.values() for signal in group}
    left = [signal for signal in offered if signal.column not in taken]
    for option, others in (('--input', '--output'), ('--output', '--input')):
        if not found[option] and found[others]:
            found[option] = left
    return Signals(tuple(found['--input']), tuple(found['--output']), time)


def _signal(column: str, name: str | None) -> Signal:
    """Return what a column's title says, under another name where one is given."""
    match = WITH_UNIT.fullmatch(column)
    title, unit = (match['name'], match['unit'].strip()) if match else (column, '')
    return Signal(name or title, unit or '1', column)


def _chosen(option: str, asked: Signal, offered: Sequence[Signal]) -> Signal:
    """Return the column of that name, with the unit of the command line where it has one."""
    for signal in offered:
        if asked.name in (signal.name, signal.column):
            unit = asked.unit if asked.unit != '1' else signal.unit
            return Signal(signal.name, unit, signal.column)
    known = [signal.name for signal in offered]
    raise ValueError(f'{option}: there is no column {quoted(asked.name)}: '
                     f'{suggest(asked.name, known)}')  # fmt: skip


def _check_unit(signal: Signal) -> None:
    unit = signal.unit
    if not (unit.isprintable() and unit.strip() == unit and 0 < len(unit) <= LONGEST_UNIT):
        raise ValueError(
            f'give {signal.name} a unit of 1 to {LONGEST_UNIT} printable characters without '
            f'space around it, not {quoted(unit)}'
        )
