"""Sensors that are none of the best: outliers, offsets in time, wraps, rounding, saturation."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from obs_ros.core.model import Variable
from obs_ros.core.typing import Array
from obs_ros.samples.range_check import LARGEST

SAME_TIME = 1e-9  # relative to an interval; times that differ by less are one


@dataclass(frozen=True)
class Sensor:
    """Faults of the sensor of one output, applied in this order; the defaults are none.

    - `delay`: the sensor's clock runs late by so many seconds: what is stamped s was measured at
      s - delay. A negative one stamps values before they are measured.
    - `outlier_rate`: probability that an outlier begins at a sample.
    - `outlier_period`: time from one outlier to the next in s; 0: only those of the rate.
    - `outlier_size`: least and most size in standard deviations of the noise, in units of the
      output where there is no noise; drawn evenly, with either sign.
    - `outlier_length`: samples that an outlier lasts; all of a burst are off by the same.
    - `outlier_value`: reading in place of an outlier, as 0 where a sensor drops out; NaN: the
      measurement is off by the size.
    - `range`: lower and upper limit of the readings, where they saturate; [0, 0]: none.
    - `resolution`: readings are rounded to multiples of it; 0: not.
    - `period`: readings are wrapped into [-period/2, period/2); 0: not.

    The value of an outlier is read as it stands: neither clipped nor rounded nor wrapped.
    """

    delay: float = 0.0
    outlier_rate: float = 0.0
    outlier_period: float = 0.0
    outlier_size: tuple[float, float] = (10.0, 10.0)
    outlier_length: int = 1
    outlier_value: float = math.nan
    range: tuple[float, float] = (0.0, 0.0)
    resolution: float = 0.0
    period: float = 0.0

    @classmethod
    def of(cls, output: Variable) -> 'Sensor':
        """Return the sensor that a model declares; one whose delay is to be estimated is in time.

        Ends of a range that are infinite are the largest values that a parameter takes.
        """
        return cls(
            delay=known_delay(output),
            range=limits(output),
            resolution=output.resolution or 0.0,
            period=output.period or 0.0,
        )

    def reading(self, value: float, outlier: float, sigma: float) -> float:
        """Return the reading of a measured `value`, off by an `outlier` (sigmas, 0: none)."""
        if outlier:
            if not math.isnan(self.outlier_value):
                return self.outlier_value
            value += outlier * sigma
        value = clipped(value, self.range)
        if self.resolution:
            value = self.resolution * round(value / self.resolution)
        if self.period:
            value = math.remainder(value, self.period)
            value = -value if value == 0.5 * self.period else value
        return value


PERFECT = Sensor()


def known_delay(signal: Variable) -> float:
    """Return the delay (s) that an input or output declares as a number, else 0."""
    return signal.delay if isinstance(signal.delay, float) else 0.0


def limits(signal: Variable) -> tuple[float, float]:
    """Return the range that an input or output declares, as `clipped` takes it."""
    if signal.range is None:
        return (0.0, 0.0)
    return max(signal.range[0], -LARGEST), min(signal.range[1], LARGEST)


def clipped(value: float, limits: tuple[float, float]) -> float:
    """Return the value inside the limits; (0, 0) are none."""
    lower, upper = limits
    return min(max(value, lower), upper) if lower < upper else value


class Outliers:
    """Outliers of some outputs, sample by sample; the same `seed` gives the same ones.

    Each output has random numbers of its own, as many for each sample whatever its faults are. So
    an outlier does not depend on when its fault was set, nor on those of other outputs.
    """

    def __init__(self, seed: int, outputs: int) -> None:
        # Not the seeds of the measurement noise, nor of random inputs.
        self._random = [np.random.default_rng((seed, 2, i)) for i in range(outputs)]
        self._left = [0] * outputs  # samples of a burst
        self._size = [0.0] * outputs

    def draw(self, sensors: Sequence[Sensor], t: float, interval: float) -> tuple[float, ...]:
        """Return the outlier of each output at time `t` in sigmas, 0 where there is none.

        The sample before was taken an `interval` (s) earlier.
        """
        return tuple(self._draw(i, s, t, interval) for i, s in enumerate(sensors))

    def _draw(self, i: int, sensor: Sensor, t: float, interval: float) -> float:
        chance, share, sign = self._random[i].random(3)
        due = chance < sensor.outlier_rate or _passed(sensor.outlier_period, t, interval)
        if not self._left[i] and due:
            least, most = sensor.outlier_size
            size = least + share * (most - least)
            self._left[i], self._size[i] = sensor.outlier_length, math.copysign(size, sign - 0.5)
        if not self._left[i]:
            return 0.0
        # A burst that is shortened while it lasts ends sooner.
        self._left[i] = min(self._left[i], sensor.outlier_length) - 1
        return self._size[i]


def _passed(period: float, t: float, interval: float) -> bool:
    """Whether a multiple of the period, other than 0, lies in (t - interval, t]."""
    if not period:
        return False
    slack = SAME_TIME * interval
    return math.floor((t + slack) / period) > max(math.floor((t + slack - interval) / period), 0)


def readings(
    sensors: Sequence[Sensor], values: Sequence[float], outliers: Sequence[float], sigma: Array
) -> tuple[float, ...]:
    """Return the readings of measured values, one for each sensor."""
    return tuple(
        sensor.reading(value, outlier, float(deviation))
        for sensor, value, outlier, deviation in zip(sensors, values, outliers, sigma, strict=True)
    )
