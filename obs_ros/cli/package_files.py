"""The files of a plant's package, made of templates, and written all or none."""

import os
import shlex
from collections.abc import Mapping
from importlib.resources import files
from pathlib import Path
from string import Template
from tempfile import TemporaryDirectory

from obs_ros.cli.first_guess import Guess
from obs_ros.core.texts import quoted

PLACES = {
    '{package}/__init__.py': '__init__.py.txt',
    '{package}/plant.py': 'plant.py.txt',
    '{package}/scenario.py': 'scenario.py.txt',
    'test/test_plant.py': 'test_plant.py.txt',
    'config/plant.yaml': 'plant.yaml.txt',
    'README.md': 'README.md.txt',
    'package.xml': 'package.xml.txt',
    'setup.py': 'setup.py.txt',
    'setup.cfg': 'setup.cfg.txt',
}
BINDING = """\
      {name}:{comment}
        topic: {topic}
        type: sensor_msgs/msg/JointState
        field: position[{name}]
"""


def package_files(
    package: str, guess: Guess, table: Path | None, period: float | None = None
) -> dict[str, str]:
    """Return the text of each file by its place in the package.

    `table` is the recording that was read, `period` (s) the time between its rows, if it was given.
    """
    templates = files('obs_ros.cli') / 'templates'
    values = {'package': package, **guess.texts(), **_said(guess, table, period)}
    made = {f'resource/{package}': ''}
    for place, name in PLACES.items():
        text = (templates / name).read_text(encoding='utf-8')
        made[place.format(package=package)] = Template(text).substitute(values)
    return made


def write_package(target: Path, texts: Mapping[str, str]) -> None:
    """Write a folder with these files, which comes to be whole or not at all.

    Raises ValueError where something is there already, OSError where nothing can be written.
    """
    if os.path.lexists(target):
        raise ValueError(f'choose another name, or move what is there: {quoted(str(target))} '
                         'exists, and nothing is overwritten')  # fmt: skip
    if not target.parent.is_dir():
        raise ValueError(f'make the folder first: there is no {quoted(str(target.parent))}')
    with TemporaryDirectory(dir=target.parent, prefix=f'.{target.name}.') as hidden:
        made = Path(hidden) / target.name
        for place, text in texts.items():
            file = made / place
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text, encoding='utf-8')
        # A folder that came meanwhile, and has something in it, is not replaced: OSError.
        made.rename(target)


def _said(guess: Guess, table: Path | None, period: float | None) -> dict[str, str]:
    """Return what templates say of signals, and of the table."""
    signals, ranges = guess.signals, guess.ranges
    outputs, inputs = (
        ', '.join(f'`{each.name}` ({each.unit})' for each in group)
        for group in (signals.outputs, signals.inputs)
    )
    return {
        'sources': f'outputs {outputs}' + (f' and inputs {inputs}' if inputs else ''),
        'made': _origin(guess, table),
        'replayed': _replayed(guess, table, period),
        'checked': ''.join(
            f' --input {signal.name}={0.25 * extent.span:.2g}'
            for signal, extent in zip(signals.inputs, ranges.inputs, strict=True)
        ),
        'half': repr(float(f'{0.5 * guess.window:.12g}')),
        'bindings': ''.join(
            BINDING.format(
                name=signal.name,
                topic=topic,
                comment='' if signal.unit == '1' else f'  # {signal.unit}',
            )
            for group, topic in ((signals.outputs, 'plant/output'), (signals.inputs, 'plant/input'))
            for signal in group
        ).rstrip('\n'),
    }


def _origin(guess: Guess, table: Path | None) -> str:
    seconds, period = guess.ranges.duration, guess.ranges.period
    if table is None:
        return 'Bounds, nominal values and window are assumptions: every signal from -10 to 10 ' \
            f'of its unit, sampled\nevery {period:.3g} s.'  # fmt: skip
    return f'Bounds, nominal values and the window come from a recording of {seconds:.4g} s, a ' \
        f'sample every\n{period:.3g} s.'  # fmt: skip


def _replayed(guess: Guess, table: Path | None, period: float | None) -> str:
    """Return the line that replays the table."""
    if table is None:
        return ''
    words = ['python', '-m', 'obs_ros.replay', str(table), '--params', 'config/plant.yaml']
    for name, column in guess.signals.columns.items():
        words += ['--column', f'{name}={column}']
    if period is not None:
        words += ['--period', repr(period)]
    return f'    {shlex.join(words)}\n'
