"""The parameters of a node out of a ROS 2 parameter file, read without ROS."""

import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import yaml

from obs_ros.core.texts import LONGEST, one_line, quoted
from obs_ros.core.yaml_document import document

LARGEST = 1_000_000  # bytes of a parameter file
DEEPEST = 32  # mappings in one another
KEY = 'ros__parameters'


class _Loader(yaml.SafeLoader):  # type: ignore[misc]
    """Takes words for what ROS takes them for: `1e-3` is a number, `1:30` and `2020-01-01` text.

    A key is text whatever it looks like: `y` and `on` are names there.
    """

    yaml_implicit_resolvers: dict[str, list[Any]] = {}  # noqa: RUF012, not those of SafeLoader

    def compose_node(self, parent: Any, index: Any) -> Any:
        if self.check_event(yaml.AliasEvent):
            event = self.get_event()
            raise yaml.composer.ComposerError(
                None, None, 'aliases (*name) are not for parameters, ROS knows none',
                event.start_mark,
            )  # fmt: skip
        return super().compose_node(parent, index)

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> Any:
        for key, _ in node.value:
            if isinstance(key, yaml.ScalarNode):
                key.tag = self.DEFAULT_SCALAR_TAG
        return super().construct_mapping(node, deep)


for _tag, _pattern in (
    ('null', r'~|null|Null|NULL|'),
    ('bool', r'[yY]|[nN]|(?:yes|no|on|off|true|false)|(?:Yes|No|On|Off|True|False)'
             r'|(?:YES|NO|ON|OFF|TRUE|FALSE)'),
    ('int', r'[-+]?(?:0[xX][0-9a-fA-F]+|[0-9]+)'),
    ('float', r'[-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?'
              r'|[-+]?\.(?:inf|Inf|INF)|\.(?:nan|NaN|NAN)'),
):  # fmt: skip
    _Loader.add_implicit_resolver(f'tag:yaml.org,2002:{_tag}', re.compile(f'(?:{_pattern})$'), None)
# SafeLoader knows yes and no, but not that ROS takes their first letters for them.
_Loader.bool_values = {**yaml.SafeLoader.bool_values, 'y': True, 'n': False}


def read_parameters(path: Path, node: str = '/estimator') -> dict[str, Any]:
    """Return the values that the file has for the node of that full name, dotted names as keys.

    Where several entries are for the node (`/**` and `/**/estimator`), the later one counts.
    Raises ValueError, with file and line, for what is no parameter file, and where it has nothing
    for this node; OSError when it cannot be read.
    """
    with path.open('rb') as file:
        text = file.read(LARGEST + 1)
    if len(text) > LARGEST:
        raise ValueError(f'{path}: more than {LARGEST} bytes are no parameter file')
    content = parse(text, str(path))
    if not isinstance(content, Mapping):
        raise ValueError(f'{path}: not a parameter file, whose first line names a node: /**:')
    values: dict[str, Any] = {}
    found = list(_nodes(content, '', str(path)))
    ours = [parameters for name, parameters in found if _stands_for(name, node)]
    if not ours:
        known = ', '.join(name for name, _ in found) or f'none with {KEY}'
        raise ValueError(
            f'{path}: nothing for the node {node}; its nodes are: {one_line(known, LONGEST)}'
        )
    for parameters in ours:
        values |= dict(_flat(parameters, '', str(path)))
    return values


def parse_assignment(text: str) -> tuple[str, Any]:
    """Return name and value of `name:=value`, as after `ros2 run ... --ros-args -p`.

    Raises ValueError for anything else.
    """
    name, separator, value = text.partition(':=')
    if not name or not separator:
        raise ValueError(f'{quoted(text)} is not of the form name:=value')
    return name, parse(value.encode(), f'-p {name}')


def parse(text: bytes, where: str) -> Any:
    """Return what the YAML says; raises ValueError with `where` and the line."""
    try:
        return document(_Loader(text))
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        line = f':{mark.line + 1}' if mark else ''
        raise ValueError(
            f'{where}{line}: {one_line(error.problem or error.context, LONGEST)}'
        ) from error
    except (yaml.YAMLError, ValueError, RecursionError) as error:
        raise ValueError(f'{where}: no valid YAML: {quoted(error)}') from error


def _nodes(content: Mapping[Any, Any], prefix: str, where: str) -> Iterator[tuple[str, Any]]:
    """Return full names of nodes, wildcards and all, with their parameters."""
    if prefix.count('/') > DEEPEST:
        raise ValueError(f'{where}: more than {DEEPEST} mappings in one another')
    for key, value in content.items():
        if key == KEY:
            yield prefix or '/', value
        elif isinstance(value, Mapping):
            yield from _nodes(value, f'{prefix}/{str(key).strip("/")}', where)
        else:
            name = one_line(f'{prefix}/{key}', LONGEST)
            raise ValueError(
                f'{where}: {name} is {quoted(value)}, but parameters stand under {KEY}'
            )


def _stands_for(pattern: str, node: str) -> bool:
    """Whether a name of the file, `*` for one part and `**` for any number, means the node."""
    parts = [part for part in pattern.split('/') if part]
    expression = ''.join(
        r'(?:/[^/]+)*' if part == '**' else '/' + re.escape(part).replace(r'\*', '[^/]*')
        for part in parts
    )
    return re.fullmatch(expression, node) is not None


def _flat(parameters: Any, prefix: str, where: str) -> Iterator[tuple[str, Any]]:
    if prefix.count('.') > DEEPEST:
        raise ValueError(f'{where}: more than {DEEPEST} mappings in one another')
    if not isinstance(parameters, Mapping):
        raise ValueError(f'{where}: {KEY} must hold names with values, not {quoted(parameters)}')
    for key, value in parameters.items():
        if isinstance(value, Mapping):
            yield from _flat(value, f'{prefix}{key}.', where)
        else:
            yield f'{prefix}{key}', value
