"""Parameters `signals.<name>`: delay, period, range and resolution of an output or input."""

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from obs_ros.core.model import Model, Variable
from obs_ros.core.parameter_spec import ParameterSpec
from obs_ros.core.periods import has_period
from obs_ros.core.variable_fields import LONGEST_DELAY, SENSOR_FIELDS, checked_sensor_field
from obs_ros.samples.range_check import LARGEST

# The values that declare nothing. ROS parameters have no None.
NOTHING: Mapping[str, float | tuple[float, float]] = {
    'delay': 0.0,
    'period': 0.0,
    'range': (-math.inf, math.inf),
    'resolution': 0.0,
}


def sensor_parameters(model: Model) -> tuple[ParameterSpec, ...]:
    """Return the parameters for what is known of each sensor and actuator of the model."""
    rows: dict[str, ParameterSpec] = {}
    for kind, group in (('input', model.inputs), ('output', model.outputs)):
        for variable in group:
            rows |= {spec.name: spec for spec in _specs(variable, kind)}
    return tuple(rows[name] for name in sorted(rows))


def with_sensors(model: Model, values: Mapping[str, Any]) -> Model:
    """Return the model with the sensors and actuators that the parameter values declare.

    Where they say what the model says, it is the very same model. A state of the name of an output
    has the period that parameters give to that, unless it has its own or the model is another one
    period on. Raises ValueError for a value that cannot be.
    """
    inputs = tuple(_declared(variable, 'input', values) for variable in model.inputs)
    outputs = tuple(_declared(variable, 'output', values) for variable in model.outputs)
    if (inputs, outputs) == (model.inputs, model.outputs):
        return model
    given = {
        new.name: new.period
        for old, new in zip(model.outputs, outputs, strict=True)
        if new.period != old.period
    }
    model = replace(model, inputs=inputs, outputs=outputs)
    states = list(model.states)
    for i, state in enumerate(states):
        period = given.get(state.name)
        if period is not None and state.period is None and has_period(model, i, period):
            states[i] = replace(state, period=period)
    return replace(model, states=states)


def _declared(variable: Variable, kind: str, values: Mapping[str, Any]) -> Variable:
    fields: dict[str, float | tuple[float, float] | None] = {}
    for field in _fields(kind):
        name = f'signals.{variable.name}.{field}'
        if (value := values[name]) == _value(variable, field):
            continue
        nothing = value == NOTHING[field]
        fields[field] = None if nothing else checked_sensor_field(name, field, value)
    return replace(variable, **fields) if fields else variable  # type: ignore[arg-type]


def _fields(kind: str) -> list[str]:
    return [field for field, kinds in SENSOR_FIELDS.items() if kind in kinds]


def _value(variable: Variable, field: str) -> float | tuple[float, float]:
    """Return the variable's value as the parameter has it."""
    value: float | tuple[float, float] | None = getattr(variable, field)
    return NOTHING[field] if value is None else value


def _specs(variable: Variable, kind: str) -> list[ParameterSpec]:
    name, unit = variable.name, variable.unit
    acts = 'acts so long after its stamp' if kind == 'input' else 'was measured so long before it'
    texts: dict[str, tuple[str, dict[str, Any]]] = {
        'delay': (
            f'{name} {acts}; [lower, upper]: estimated within these',
            {'unit': 's', 'lower': -LONGEST_DELAY, 'upper': LONGEST_DELAY, 'or_pair': True},
        ),
        'period': (
            f'{name} wraps after so much, as an angle does; 0: it does not',
            {'unit': unit, 'lower': 0.0, 'upper': LARGEST},
        ),
        'range': (
            f'{name} is clipped to [low, high]'
            if kind == 'input'
            else f'the sensor of {name} saturates at [low, high]',
            {'unit': unit, 'length': 2},
        ),
        'resolution': (
            f'step from one value that the sensor of {name} can report to the next; 0: not known',
            {'unit': unit, 'lower': 0.0, 'upper': LARGEST},
        ),
    }
    return [
        ParameterSpec(
            f'signals.{name}.{field}',
            _value(variable, field),
            texts[field][0],
            read_only=True,
            **texts[field][1],
        )
        for field in _fields(kind)
    ]
