"""`ros2 run obs_ros init PACKAGE`: a package for a plant of one's own, to begin with.

Writes a ROS 2 Python package with a model, a scenario, bindings, a test and a README, from the
names and units of inputs and outputs, or from the header of a table. Asks for nothing, overwrites
nothing. The model is a first guess that runs: replace it with the plant's equations.
"""

import argparse
import keyword
import math
import re
import signal
import sys
from collections.abc import Mapping, Sequence
from importlib.util import find_spec
from pathlib import Path

from obs_ros.cli.first_guess import Guess
from obs_ros.cli.package_files import package_files, write_package
from obs_ros.cli.package_signals import named, of_header, of_names
from obs_ros.cli.recorded_ranges import assumed, header_of, recorded
from obs_ros.core.texts import one_line, quoted

LONGEST_PACKAGE = 60  # characters
OWN = ('config', 'resource', 'setup', 'test')  # files and folders beside the package's modules


def main(arguments: Sequence[str] | None = None) -> int:
    """Write the package that the command line names; 1, with one line on stderr, if it cannot."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        print('\n'.join(run(_options().parse_args(arguments))))
    except KeyboardInterrupt:
        print('init: stopped; nothing was written', file=sys.stderr)
        return 130
    except (ValueError, OSError) as error:
        print(f'init: {one_line(error)}', file=sys.stderr)
        return 1
    return 0


def run(options: argparse.Namespace) -> list[str]:
    """Write the package; return what to tell its user.

    Raises ValueError or OSError where nothing was written.
    """
    check_package_name(options.package)
    inputs = [named('--input', text) for text in options.inputs]
    outputs = [named('--output', text) for text in options.outputs]
    period, table = options.period, options.csv
    if period is not None and not (math.isfinite(period) and period > 0.0):
        raise ValueError(f'--period must be a time in s above 0, not {period:g}')
    columns = _columns(options.columns)
    if table is None:
        if columns:
            raise ValueError('--column is for a table: give it with --csv FILE')
        signals = of_names(inputs, outputs)
        guess = Guess(signals, assumed(signals, period))
    else:
        signals = of_header(header_of(table), columns, inputs, outputs)
        guess = Guess(signals, recorded(table, signals, period))
    target = options.destination / options.package
    place = table.resolve() if table is not None else None
    write_package(target, package_files(options.package, guess, place, period))
    model = f'{target}/{options.package}/plant.py'
    return [
        f'{one_line(target)}: a package with a first guess, {len(signals.parameters)} parameters '
        f'in windows of {guess.window:g} s',
        f'replace the guess in {one_line(model)}; {one_line(target / "README.md")} says how, and '
        'what to run',
    ]


def check_package_name(name: str) -> None:
    """Raise ValueError for what ROS 2 or Python cannot have as a package, or have already."""
    plain = re.fullmatch(r'[a-z](?:_?[a-z0-9])+', name, re.ASCII)
    if not plain or len(name) > LONGEST_PACKAGE or keyword.iskeyword(name):
        raise ValueError(
            'name the package with small letters, digits and single _, beginning with a letter '
            f'(2 to {LONGEST_PACKAGE} characters, no word of Python), not {quoted(name)}'
        )
    if name in OWN or name in sys.stdlib_module_names or _installed(name):
        raise ValueError(
            f'choose another name: {quoted(name)} is one that Python or the package itself uses'
        )


def _installed(name: str) -> bool:
    """Whether a module of that name can be imported, folders without an __init__.py apart."""
    try:
        found = find_spec(name)
    except ValueError:  # of a module that lacks a spec
        return True
    return found is not None and found.origin is not None


def _columns(texts: Sequence[str]) -> Mapping[str, str]:
    columns: dict[str, str] = {}
    for text in texts:
        name, _, column = text.partition('=')
        if not (name and column):
            raise ValueError(f'--column must be NAME=COLUMN, not {quoted(text)}')
        if name in columns or column in columns.values():
            raise ValueError(f'name each column once: --column {quoted(text)} is the second')
        columns[name] = column
    return columns


def _options() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog='init', description=(__doc__ or '').partition('\n\n')[2].strip()
    )
    add = parser.add_argument
    add('package', metavar='PACKAGE', help='the name of the package, and of the new folder')
    for kind in ('input', 'output'):
        add(
            f'--{kind}',
            dest=f'{kind}s',
            action='append',
            default=[],
            metavar='NAME=UNIT',
            help=f'an {kind}; of a table, one of its columns. Without any, all that are left',
        )
    add('--csv', type=Path, metavar='FILE', help='a table (.csv, .tsv, .txt), as replay reads it')
    add(
        '--column',
        dest='columns',
        action='append',
        default=[],
        metavar='NAME=COLUMN',
        help='another name for a column of the table; t=COLUMN: the time',
    )
    add('--period', type=float, metavar='S', help='s from row to row, or from sample to sample')
    add(
        '--destination-directory',
        dest='destination',
        type=Path,
        default=Path(),
        metavar='DIR',
        help='the folder to write it in (default: this one)',
    )
    return parser


if __name__ == '__main__':
    sys.exit(main())
