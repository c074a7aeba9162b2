"""The fields of a Variable, checked: numbers, priors, and what a sensor or actuator is."""

import contextlib
import math
from collections.abc import Iterable
from numbers import Real

import numpy as np

from obs_ros.core.texts import quoted

# The properties of sensors and actuators, with the kinds of variables that may have them.
SENSOR_FIELDS = {
    'delay': ('input', 'output'),
    'period': ('state', 'output'),
    'range': ('input', 'output'),
    'resolution': ('output',),
}
LONGEST_DELAY = 1e6  # s, of either sign: memory and search stay bounded


def number(what: str, value: object) -> float:
    """Return the number as a float; raises ValueError for what is none."""
    if isinstance(value, Real) and not isinstance(value, bool):
        with contextlib.suppress(OverflowError):
            return float(value)
    raise ValueError(f'{what} must be a number, not {quoted(value)}')


def checked_prior(name: str, prior: object, log: bool) -> tuple[float, float]:
    """Return mean and standard deviation as floats; raises ValueError for what cannot be them.

    `log` says that the variable is on a log scale.
    """
    mean, sd = _pair(f'{name}: prior', prior, '(mean, standard deviation)')
    if not math.isfinite(mean):
        raise ValueError(f'{name}: prior mean {mean} is not finite')
    if not 0.0 < sd < math.inf:
        raise ValueError(f'{name}: prior standard deviation {sd} is not positive and finite')
    if log and not mean > 0.0:
        raise ValueError(f'{name}: prior mean {mean} must be positive on a log scale')
    return mean, sd


def checked_sensor_field(name: str, field: str, value: object) -> float | tuple[float, float]:
    """Return one of the SENSOR_FIELDS of a variable as floats; raises ValueError for a wrong one.

    A period or resolution is positive and finite; a range has two ends that rise, one of them
    infinite at most; a delay is a time in s, or its two bounds, within +-LONGEST_DELAY.
    """
    if field == 'range':
        return _range(name, value)
    return _delay(name, value) if field == 'delay' else _size(name, field, value)


def check_kind(what: str, kind: str, fields: Iterable[str]) -> None:
    """Raise ValueError for one of the fields that a variable of this kind cannot have."""
    for field in fields:
        if kind not in SENSOR_FIELDS[field]:
            others = ' and '.join(f'{each}s' for each in SENSOR_FIELDS[field])
            raise ValueError(f'{what} is one of the {kind}s, but only {others} have a {field}')


def _size(name: str, field: str, value: object) -> float:
    size = number(f'{name}: {field}', value)
    if not 0.0 < size < math.inf:
        raise ValueError(f'{name}: {field} {size} is not positive and finite')
    return size


def _range(name: str, value: object) -> tuple[float, float]:
    low, high = _pair(f'{name}: range', value, '(low, high)')
    if not low < high:
        raise ValueError(f'{name}: the low end {low} of its range is not below the high end {high}')
    if math.isinf(low) and math.isinf(high):
        raise ValueError(f'{name}: leave the range out, as {low} to {high} limits nothing')
    return low, high


def _delay(name: str, value: object) -> float | tuple[float, float]:
    if not isinstance(value, list | tuple | np.ndarray):
        delay = number(f'{name}: delay', value)
        _check_delay(name, delay)
        return delay
    lower, upper = _pair(f'{name}: delay', value, 'a time in s, or (lower, upper) to estimate it')
    _check_delay(name, lower)
    _check_delay(name, upper)
    if not lower < upper:
        raise ValueError(f'{name}: delay from {lower} s is not below its upper bound {upper} s')
    return lower, upper


def _check_delay(name: str, delay: float) -> None:
    if not abs(delay) <= LONGEST_DELAY:
        raise ValueError(f'{name}: delay {delay} s is not within +-{LONGEST_DELAY:g} s')


def _pair(what: str, value: object, form: str) -> tuple[float, float]:
    """Return two numbers as floats; raises ValueError, naming the `form`, for anything else."""
    if not isinstance(value, list | tuple | np.ndarray) or len(value) != 2:
        raise ValueError(f'{what} must be {form}, not {quoted(value)}')
    first, second = (number(what, entry) for entry in value)
    return first, second
