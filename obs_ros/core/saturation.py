"""Sensors and actuators at the ends of their range.

A sensor that shows an end of its range says only that the output is there or beyond. There a model
is contradicted where it is inside the range, and by as much as it is: the one-sided residual of a
censored sample (Tobin 1958), whose square has a continuous slope.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from obs_ros.core.model import Variable
from obs_ros.core.typing import Array, BoolArray


@dataclass(frozen=True)
class SaturationSettings:
    """How near an end of its range a sensor shows that end.

    - `steps`: of the resolution, where that is known: the nearest value that the sensor can show;
    - `share`: of the range or, where that is open, of its end: more than floats are rounded by.
    """

    steps: float = 0.5
    share: float = 1e-6


DEFAULT = SaturationSettings()


@dataclass(frozen=True)
class Ends:
    """Bounds (..., r) between which outputs are compared with measured ones.

    They are finite at saturated samples only: the end that the sensor shows.
    """

    low: Array
    high: Array

    def __getitem__(self, nodes: slice) -> 'Ends':
        """Return the ends at some of the samples."""
        return Ends(self.low[nodes], self.high[nodes])

    @property
    def saturated(self) -> BoolArray:
        """Which samples (..., r) are saturated."""
        return np.asarray(np.isfinite(self.low) | np.isfinite(self.high))

    def shown(self, outputs: Array) -> Array:
        """Return outputs (..., r) or (..., r, B) as the sensors show them; NaN stays NaN."""
        if outputs.ndim > self.low.ndim:
            return np.clip(outputs, self.low[..., None], self.high[..., None])
        return np.clip(outputs, self.low, self.high)

    def measured(self, y: Array) -> Array:
        """Return measured outputs (..., r), exactly at the ends that saturated sensors show."""
        y = np.where(np.isfinite(self.low), self.low, y)
        return np.where(np.isfinite(self.high), self.high, y)

    def beyond(self, outputs: Array) -> BoolArray:
        """Return which samples (..., r) are saturated with outputs there or beyond.

        These say nothing: the model agrees, wherever it is.
        """
        return np.asarray(self.saturated & ((outputs <= self.low) | (outputs >= self.high)))


def has_range(variables: Sequence[Variable]) -> bool:
    """Whether any of the variables has a range."""
    return any(variable.range is not None for variable in variables)


def ranges(variables: Sequence[Variable]) -> tuple[Array, Array]:
    """Return low and high ends (n,) of the variables' ranges, infinite where there are none."""
    pairs = [variable.range or (-math.inf, math.inf) for variable in variables]
    low, high = np.array(pairs, dtype=np.float64).reshape(-1, 2).T.copy()
    return low, high


def ends_of(
    outputs: Sequence[Variable], y: Array, settings: SaturationSettings = DEFAULT
) -> Ends | None:
    """Return the ends that measured outputs (..., r) show, NaN = not measured.

    None where no output has a range.
    """
    if not has_range(outputs):
        return None
    low, high = ranges(outputs)
    sizes = np.array([_size(variable) for variable in outputs])
    steps = np.array([variable.resolution or 0.0 for variable in outputs])
    near = np.maximum(settings.share * sizes, settings.steps * steps)
    return Ends(np.where(y <= low + near, low, -np.inf), np.where(y >= high - near, high, np.inf))


def _size(variable: Variable) -> float:
    """Return the width of a range or, where that is open, the size of its end."""
    finite = [end for end in variable.range or () if math.isfinite(end)]
    return finite[1] - finite[0] if len(finite) == 2 else sum(map(abs, finite))


def unsaturated(outputs: Sequence[Variable], y: Array) -> Array:
    """Return measured outputs (..., r), NaN where their sensors are saturated."""
    ends = ends_of(outputs, y)
    return y if ends is None else np.where(ends.saturated, np.nan, y)


def contradicting(outputs: Sequence[Variable], y: Array, predicted: Array) -> Array:
    """Return measured outputs y (r,) as far as they may contradict those predicted (r,).

    A saturated sensor shows the end of its range, and is NaN where the prediction is there or
    beyond. Without any range the very same array comes back.
    """
    ends = ends_of(outputs, y)
    if ends is None:
        return y
    return np.where(ends.beyond(predicted), np.nan, ends.measured(y))


def at_an_end(outputs: Sequence[Variable], y: Array) -> Array:
    """Return outputs (r,), at an end of their range those that have one."""
    low, high = ranges(outputs)
    return np.where(np.isfinite(high), high, np.where(np.isfinite(low), low, y))


def applied(inputs: Sequence[Variable], u: Array) -> Array:
    """Return inputs (..., m) as their actuators apply them: clipped to their ranges.

    NaN stays NaN; without any range the very same array comes back.
    """
    if not has_range(inputs):
        return u
    return np.clip(u, *ranges(inputs))
