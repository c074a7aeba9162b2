"""What `--help` of a node prints: usage and parameters, without ROS."""

import textwrap
from collections.abc import Iterable, Mapping

from obs_ros.core.parameter_spec import ParameterSpec, plain

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
