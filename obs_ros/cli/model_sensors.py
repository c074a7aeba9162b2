"""Sensors and actuators of a model: what is declared of them, and what cannot be meant."""

from collections.abc import Iterator, Sequence

import numpy as np

from obs_ros.core.model import Model, Variable
from obs_ros.core.saturation import unsaturated
from obs_ros.core.typing import Array
from obs_ros.core.variable_fields import SENSOR_FIELDS


def declared(variable: Variable) -> str:
    """Return the words on all that is declared of a sensor or actuator, each after a comma."""
    return ''.join(
        f', {field} {_words(variable, field)}'
        for field in SENSOR_FIELDS
        if getattr(variable, field) is not None
    )


def check_sensors(model: Model, window: float) -> None:
    """Raise ValueError for what no sensor or actuator can be, in windows of that length (s)."""
    for kind, group in (('input', model.inputs), ('output', model.outputs)):
        for variable in group:
            for wrong in _wrong(variable, window):
                raise ValueError(f'{kind} {variable.name}: {wrong}')


def limited(variable: Variable, values: Array) -> str:
    """Say of how many values (K,) of an input the actuator makes others; nothing if of none."""
    low, high = variable.range or (-np.inf, np.inf)
    share = float(np.mean((values < low) | (values > high)))
    return f'; its actuator limits {share:.0%} of the samples' if share else ''


def shown(variable: Variable, values: Array) -> str:
    """Say what a sensor cannot show of an output's values (K,); nothing if it shows them all."""
    said, spread = '', float(np.ptp(values))
    if variable.range is not None:
        missing = np.isnan(unsaturated([variable], values[:, None])).mean()
        said += f'; its sensor is saturated in {missing:.0%} of the samples'
    if variable.resolution is not None and 0.0 < spread < variable.resolution:
        said += '; all that it moves by is less than its resolution'
    return said


def _words(variable: Variable, field: str) -> str:
    value = getattr(variable, field)
    unit = 's' if field == 'delay' else variable.unit
    after = '' if unit == '1' else f' {unit}'
    if not isinstance(value, tuple):
        return f'{value:g}{after}'
    between = f'{value[0]:g} to {value[1]:g}{after}'
    return f'estimated within {between}' if field == 'delay' else between


def _wrong(variable: Variable, window: float) -> Iterator[str]:
    """Return what cannot be meant, advice first."""
    longest = max(abs(each) for each in _ends(variable.delay))
    if longest >= window:
        yield (
            f'take a longer --window, or check the delay: {longest:g} s are no less than the '
            f'window of {window:g} s'
        )
    low, high = variable.range or (-np.inf, np.inf)
    nominal, step = variable.nominal, variable.resolution
    if nominal is not None and not low <= nominal <= high:
        yield (
            f'change the range or the nominal value: {nominal:g} lies outside {low:g} to {high:g}'
        )
    if step is not None and step >= high - low:
        yield f'make the resolution finer than {step:g}, as its range is {low:g} to {high:g}'
    if step is not None and variable.period is not None and step >= variable.period:
        yield f'make the resolution finer than {step:g}, as its period is {variable.period:g}'


def _ends(delay: float | tuple[float, float] | None) -> Sequence[float]:
    """Return the bounds of a delay that is estimated, or the delay."""
    return delay if isinstance(delay, tuple) else (delay or 0.0,)
