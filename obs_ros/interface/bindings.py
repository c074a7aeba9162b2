"""Parameters `signals.<name>`: the topic and field of an output or input, and all of that name."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from obs_ros.core.model import Model, names
from obs_ros.core.parameter_spec import ParameterSpec
from obs_ros.core.registry import suggest
from obs_ros.core.texts import LONGEST, one_line, quoted
from obs_ros.core.variable_fields import SENSOR_FIELDS, check_kind
from obs_ros.interface.field_path import FieldPath
from obs_ros.interface.sensors import sensor_parameters
from obs_ros.samples.range_check import LARGEST

HEADER, ARRIVAL = 'header', 'arrival'


@dataclass(frozen=True)
class Binding:
    """One output or input: `scale` times the number at `path`, plus `offset`.

    `type` names the messages on `topic`; their `stamp` is that of their header, or their arrival.
    """

    name: str
    topic: str
    type: str
    path: FieldPath
    scale: float
    offset: float
    stamp: str


def signal_parameters(model: Model) -> tuple[ParameterSpec, ...]:
    """Return the parameters that bind and describe each output and input of the model."""
    units = {v.name: v.unit for v in (*model.inputs, *model.outputs)}
    bound = (spec for name in sorted(units) for spec in _specs(name, units[name]))
    return (*bound, *sensor_parameters(model))


def bindings(
    model: Model, values: Mapping[str, Any], unknown: Sequence[str] = ()
) -> dict[str, Binding]:
    """Return the bindings by the name of the output or input; those with no topic have none.

    `unknown` are names of parameters given that do not exist. Raises ValueError for these, and for
    a binding that is incomplete or wrong.
    """
    signals = sorted({*names(model.inputs), *names(model.outputs)})
    for given in unknown:
        name, _, rest = given.removeprefix('signals.').rpartition('.')
        if name in signals:
            if rest in SENSOR_FIELDS:
                kind = 'input' if name in names(model.inputs) else 'output'
                check_kind(f'{given}: {name}', kind, [rest])
            prefix = f'signals.{name}.'
            known = [
                spec.name.removeprefix(prefix)
                for spec in signal_parameters(model)
                if spec.name.startswith(prefix)
            ]
            raise ValueError(f'there is no parameter {quoted(given)}: {suggest(rest, known)}')
        raise ValueError(
            f'{one_line(given, LONGEST)}: model {quoted(model.name)} has no output or input '
            f'{quoted(name or rest)}: {suggest(name or rest, signals)}'
        )
    found = {name: _binding(name, values) for name in signals}
    return {name: binding for name, binding in found.items() if binding is not None}


def _specs(name: str, unit: str) -> tuple[ParameterSpec, ...]:
    def spec(part: str, default: str | float, description: str, **more: Any) -> ParameterSpec:
        return ParameterSpec(f'signals.{name}.{part}', default, description, read_only=True, **more)

    return (
        spec('topic', '', f'where {name} is published; empty: on plant/output or plant/input'),
        spec('type', '', 'type of its messages, package/msg/Type'),
        spec('field', '', 'path to the number, as in position[joint] or pose.position.x'),
        spec('scale', 1.0, f'{name} is this times the number, plus the offset',
             lower=-LARGEST, upper=LARGEST),
        spec('offset', 0.0, f'added to {name} after scaling', unit=unit, lower=-LARGEST,
             upper=LARGEST),
        spec(
            'stamp', HEADER, "the sample's time: header.stamp, or when the message arrives",
            choices=(HEADER, ARRIVAL),
        ),
    )  # fmt: skip


def _binding(name: str, values: Mapping[str, Any]) -> Binding | None:
    prefix = f'signals.{name}.'
    given = {spec.name.removeprefix(prefix): values[spec.name] for spec in _specs(name, '')}
    if not given['topic']:
        for spec in _specs(name, ''):
            if values[spec.name] != spec.default:
                raise ValueError(f'{spec.name} is given, but {prefix}topic is not')
        return None
    for part, example in (('type', 'std_msgs/msg/Float64'), ('field', 'data')):
        if not given[part]:
            raise ValueError(
                f'{prefix}topic is given, but {prefix}{part} is not; it may be {quoted(example)}'
            )
    try:
        path = FieldPath.parse(given['field'])
    except ValueError as error:
        raise ValueError(f'{prefix}field: {error}') from None
    if not math.isfinite(given['scale']) or not given['scale']:
        raise ValueError(f'{prefix}scale must be a finite number other than 0')
    if not math.isfinite(given['offset']):
        raise ValueError(f'{prefix}offset must be a finite number, not {given["offset"]}')
    return Binding(
        name, given['topic'], given['type'], path, given['scale'], given['offset'], given['stamp']
    )
