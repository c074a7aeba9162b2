"""Texts on parameters: the `--help` of a node, and the page of the observers' own, without ROS."""

import textwrap
from collections.abc import Iterable, Mapping
from typing import Any

from obs_ros.core.parameter_spec import ParameterSpec, markdown_table, plain
from obs_ros.interface.parameters import CHOICE, COMMON, LIVE, own_prefix
from obs_ros.observers.base import OBSERVERS, load_observer
from obs_ros.observers.settings import parameter_specs

WIDTH, INDENT = 100, 4  # characters


def node_usage(
    name: str,
    purpose: str,
    specs: Iterable[ParameterSpec],
    families: Mapping[str, str],
    more: Iterable[str],
) -> str:
    """Return the help of a node: `families` are parameters that the model's names complete."""
    lines = [
        f'usage: ros2 run obs_ros {name} [--ros-args [-p NAME:=VALUE] [--params-file FILE] '
        '[-r FROM:=TO]]',
        '',
        *textwrap.wrap(purpose, WIDTH),
        '',
        'parameters, with their defaults:',
    ]
    for spec in specs:
        default = plain(spec.default)
        text = str(default).lower() if isinstance(default, bool) else f'{default!r}'
        lines += [f'  {spec.name} ({text})', *_indented(spec.describe())]
    if families:
        lines += ['', "and by the model's names:"]
    for family, text in families.items():
        lines += [f'  {family}', *_indented(text)]
    for paragraph in more:
        lines += ['', *textwrap.wrap(paragraph, WIDTH, break_on_hyphens=False)]
    return '\n'.join(lines) + '\n'


def _indented(text: str) -> list[str]:
    indent = ' ' * INDENT
    return textwrap.wrap(
        text, WIDTH, initial_indent=indent, subsequent_indent=indent, break_on_hyphens=False
    )


def usage() -> str:
    """Return what `estimator --help` prints."""
    return node_usage(
        'estimator',
        'Estimates states and parameters of a plant while it runs: from plant/output and '
        'plant/input, or what signals.* name, to ~/state, ~/parameters, ~/jump and /diagnostics.',
        (*CHOICE, *LIVE, *COMMON),
        {
            'bounds.NAME': '[lower, upper] of a state or parameter',
            'fixed.NAME': 'holds a state or parameter there; nan: it is estimated, or nominal',
            'initial.NAME': 'a start that the next window tries beside its own; nan: none',
            'noise.OUTPUT': 'standard deviation of a measured output; 0: estimated',
            'walk.NAME': 'standard deviation by which a state or parameter wanders in 1 s; 0: none',
            'prior.NAME': '[mean, standard deviation] of a parameter, or of a state at the start; '
                '[0, 0]: nothing is known',
            'signals.NAME.topic, .type, .field, .scale, .offset, .stamp':
                'where an output or input comes from (at start only)',
            'signals.NAME.delay, .period, .range, .resolution':
                'what its sensor or actuator does, with or without a topic (at start only)',
        },
        (
            'Each with a comment: share/obs_ros/config/three_tank.yaml. Of other observers: '
            'docs/observer-parameters.md. A plant of your own: docs/your-own-plant.md.',
        ),
    )  # fmt: skip


def settings_page() -> str:
    """Return, in Markdown, the settings that each immediate observer has of its own."""
    parts = [
        '# Settings of the observers\n\n'
        'Parameters of each observer that goes sample by sample, besides those that all share\n'
        '(`parameters`, `states`, `seed`, `bounds.<name>`, `fixed.<name>`, `noise.<output>`,\n'
        '`initial.<name>`, `stale_after`). `ekf` and `ukf` take `walk.<name>` and `prior.<name>`\n'
        'too, which count before the shares below. [Which observer?](which-observer.md) says what\n'
        'each is for.\n\nThis page is made by `python -m obs_ros.interface.usage`.'
    ]
    for name in sorted(OBSERVERS):
        observer: Any = load_observer(name)
        if observer.immediate:
            rows = parameter_specs(observer.Settings, own_prefix(name))
            parts.append(f'## {name}\n\n{markdown_table(rows).rstrip()}')
    return '\n\n'.join(parts) + '\n'


if __name__ == '__main__':
    print(settings_page(), end='')
