"""Parameters that break a plant while it runs: its own parameters, its sensors, its actuators."""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from obs_ros.core.estimated_delays import own_parameters
from obs_ros.core.model import Model, names
from obs_ros.core.parameter_spec import ParameterSpec
from obs_ros.samples.range_check import LARGEST
from plant_sim.actuators import IDEAL, Actuator
from plant_sim.sensors import PERFECT, Sensor

SENSOR, ACTUATOR = 'sensor.', 'actuator.'


@dataclass(frozen=True)
class FaultLimits:
    """Limits of what a remote caller may set.

    - `delay`: longest offset in time or dead time in s.
    - `samples`: sample intervals of such a time; so many instants or inputs are kept.
    - `steps`: of the plant in such a time, which it takes at once where a sensor is early: 1 s.
    - `size`: standard deviations of an outlier.
    - `length`: samples of a burst.
    - `outlier_period`: longest time between outliers in s.
    """

    delay: float = 1000.0
    samples: int = 1000
    steps: float = 1e5
    size: float = 1e6
    length: int = 1_000_000
    outlier_period: float = 1e9


LIMITS = FaultLimits()


def fault_parameters(model: Model) -> tuple[ParameterSpec, ...]:
    """Return one parameter per plant parameter: set it while running to inject a fault."""
    return tuple(
        ParameterSpec(f'plant.{v.name}', math.nan,
            f'holds {v.name} there, whatever the scenario has scheduled; nan: as scheduled',
            v.unit, lower=max(v.lower, -LARGEST), upper=min(v.upper, LARGEST), nan=True)
        for v in own_parameters(model.parameters)
    )  # fmt: skip


def instrument_parameters(model: Model) -> tuple[ParameterSpec, ...]:
    """Return the parameters of the sensor of each output, and of the actuator of each input.

    Their defaults are the sensors and actuators that the model declares.
    """
    outputs = (sensor_parameters(v.name, v.unit, Sensor.of(v)) for v in model.outputs)
    inputs = (actuator_parameters(v.name, v.unit, Actuator.of(v)) for v in model.inputs)
    return tuple(spec for specs in (*outputs, *inputs) for spec in specs)


def sensor_parameters(
    name: str, unit: str = '', declared: Sensor = PERFECT
) -> tuple[ParameterSpec, ...]:
    """Return the parameters of the sensor of the output `name`, as fields of `Sensor`."""

    def spec(field: str, description: str, unit: str = '', **more: Any) -> ParameterSpec:
        return ParameterSpec(f'{SENSOR}{name}.{field}', getattr(declared, field),
                             description, unit, **more)  # fmt: skip

    return (
        spec('delay', 'what is stamped s was measured at s - delay; < 0: stamped too early', 's',
             lower=-LIMITS.delay, upper=LIMITS.delay),
        spec('outlier_rate', 'probability that an outlier begins at a sample', lower=0.0,
             upper=1.0),
        spec('outlier_period', 'time from one outlier to the next; 0: only those of the rate', 's',
             lower=0.0, upper=LIMITS.outlier_period),
        spec('outlier_size', 'least and most of an outlier in standard deviations of the noise, '
             'of either sign; without noise in units of the output', lower=0.0,
             upper=LIMITS.size, length=2),
        spec('outlier_length', 'samples that an outlier lasts: a burst', lower=1,
             upper=LIMITS.length),
        spec('outlier_value', 'reading in place of an outlier, 0 for a dropout; nan: it is off by '
             'its size', unit, lower=-LARGEST, upper=LARGEST, nan=True),
        spec('range', 'limits at which readings saturate; [0, 0]: none', unit, lower=-LARGEST,
             upper=LARGEST, length=2),
        spec('resolution', 'readings are rounded to multiples of it; 0: not', unit, lower=0.0,
             upper=LARGEST),
        spec('period', 'readings are wrapped into [-period/2, period/2); 0: not', unit, lower=0.0,
             upper=LARGEST),
    )  # fmt: skip


def actuator_parameters(
    name: str, unit: str = '', declared: Actuator = IDEAL
) -> tuple[ParameterSpec, ...]:
    """Return the parameters of the actuator of the input `name`, as fields of `Actuator`."""
    prefix = f'{ACTUATOR}{name}.'
    return (
        ParameterSpec(f'{prefix}delay', declared.delay,
            'dead time: what is told at s acts from s + delay on', 's', lower=0.0,
            upper=LIMITS.delay),
        ParameterSpec(f'{prefix}range', declared.range,
            'limits of the input that acts; [0, 0]: none', unit, lower=-LARGEST, upper=LARGEST,
            length=2),
    )  # fmt: skip


def plant_faults(values: Mapping[str, Any]) -> dict[str, float]:
    """Return the plant's parameters that are held, by name."""
    given = ((k.removeprefix('plant.'), v) for k, v in values.items() if k.startswith('plant.'))
    return {name: value for name, value in given if not math.isnan(value)}


def sensors(model: Model, values: Mapping[str, Any]) -> dict[str, Sensor]:
    """Return the sensors that are not perfect, by output."""
    given = {name: _given(sensor_parameters(name), values) for name in names(model.outputs)}
    return {name: Sensor(**fields) for name, fields in given.items() if fields}


def actuators(model: Model, values: Mapping[str, Any]) -> dict[str, Actuator]:
    """Return the actuators that are not perfect, by input."""
    given = {name: _given(actuator_parameters(name), values) for name in names(model.inputs)}
    return {name: Actuator(**fields) for name, fields in given.items() if fields}


def told(model: Model, values: Mapping[str, Any]) -> str:
    """Return all faults that are set, in one line, or `none`: what the model declares is none."""
    rows = (*fault_parameters(model), *instrument_parameters(model))
    given = ((spec.name, values[spec.name]) for spec in rows if not _same(spec, values))
    return ', '.join(f'{name.removeprefix("plant.")}={_text(value)}' for name, value in given) or (
        'none'
    )


def check_faults(model: Model, values: Mapping[str, Any], period: float) -> None:
    """Raise ValueError for faults that make no sense with a sample every `period` s, or block."""
    for spec in instrument_parameters(model):
        value, field = values[spec.name], spec.name.rpartition('.')[2]
        if isinstance(value, tuple) and value[0] > value[1]:
            raise ValueError(f'{spec.name} must be [lower, upper], not {list(value)}')
        if field == 'range' and value[0] == value[1] != 0.0:
            raise ValueError(f'{spec.name} must be wider than {list(value)}; [0, 0]: none')
        if field == 'delay':
            _check_delay(spec.name, abs(value), model, period)


def _check_delay(name: str, delay: float, model: Model, period: float) -> None:
    if delay > LIMITS.samples * period * (1.0 + 1e-9):
        raise ValueError(
            f'shorten {name}, or lower rate: {delay:g} s are {delay / period:.3g} samples, '
            f'at most {LIMITS.samples}'
        )
    if delay > LIMITS.steps * model.max_step:
        raise ValueError(
            f'shorten {name}: in {delay:g} s the plant takes {delay / model.max_step:.2g} steps, '
            f'at most {LIMITS.steps:g}'
        )


def _given(specs: Iterable[ParameterSpec], values: Mapping[str, Any]) -> dict[str, Any]:
    """Return the fields that are not the default."""
    return {s.name.rpartition('.')[2]: values[s.name] for s in specs if not _same(s, values)}


def _same(spec: ParameterSpec, values: Mapping[str, Any]) -> bool:
    value, default = values[spec.name], spec.default
    if isinstance(default, float) and math.isnan(default):
        return math.isnan(value)
    return bool(value == default)


def _text(value: Any) -> str:
    return str(list(value)) if isinstance(value, tuple) else f'{value:g}'
