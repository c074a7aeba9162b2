"""Signals that drive and disturb a plant: schedules, ramps, measurement noise."""

import bisect
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from obs_ros.core.typing import Array

# Values at time t (s).
Signal = Callable[[float], tuple[float, ...]]


@dataclass(frozen=True)
class Schedule:
    """Piecewise constant values: `values[i]` from `times[i]` (s) on, the last one for ever.

    Raises ValueError unless times start at 0 and rise, with one row of equal length for each.
    """

    times: Sequence[float]
    values: Sequence[Sequence[float]]

    def __post_init__(self) -> None:
        times = tuple(float(t) for t in self.times)
        values = tuple(tuple(float(v) for v in row) for row in self.values)
        if not times or times[0] != 0.0 or any(b <= a for a, b in pairwise(times)):
            raise ValueError(f'schedule times must start at 0 and rise: {times}')
        if len(values) != len(times) or len({len(row) for row in values}) != 1:
            raise ValueError(f'a schedule needs one row of equal length per time: {values}')
        object.__setattr__(self, 'times', times)
        object.__setattr__(self, 'values', values)

    def __call__(self, t: float) -> tuple[float, ...]:
        """Return the values in force at `t`, those of a change exactly then included."""
        row = max(0, bisect.bisect_right(self.times, t) - 1)
        return tuple(self.values[row])

    def next_change(self, t: float) -> float:
        """Return the first time after `t` at which values change, or infinity."""
        after = bisect.bisect_right(self.times, t)
        return self.times[after] if after < len(self.times) else math.inf


def constant(*values: float) -> Schedule:
    """Return a schedule that never changes."""
    return Schedule((0.0,), (values,))


def ramp(times: Sequence[float], values: Sequence[float]) -> Signal:
    """Return one value that runs straight from each of `times` (s) to the next, and then stays."""
    return lambda t: (float(np.interp(t, times, values)),)


def noise_deviation(snr_db: float, power: float | Array = 1.0) -> Array:
    """Return the standard deviation of noise at `snr_db` below a signal of mean-square `power`.

    The papers add noise to a signal taken to have unit power, whatever its real one.
    """
    return np.asarray(np.sqrt(power) * 10.0 ** (-snr_db / 20.0))


class Noise:
    """Gaussian noise, one column per output; the same `seed` gives the same noise.

    It is white, or with a `correlation` in [0, 1) from one draw to the next, as samples of an
    Ornstein-Uhlenbeck process have: exp(-period / time constant).
    """

    def __init__(self, seed: int, outputs: int, correlation: float = 0.0) -> None:
        self._random = np.random.default_rng(seed)
        self._outputs = outputs
        self._correlation = correlation
        self._unit: Array | None = None

    def draw(self, deviation: float | Array) -> Array:
        """Return the next (outputs,) values; each call draws the same numbers, scaled."""
        fresh = self._random.standard_normal(self._outputs)
        if self._correlation and self._unit is not None:
            kept = self._correlation
            fresh = kept * self._unit + math.sqrt(1.0 - kept * kept) * fresh
        self._unit = fresh
        return deviation * fresh
