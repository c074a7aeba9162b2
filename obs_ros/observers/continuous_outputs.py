"""Outputs of sensors that wrap, as an observer that goes sample by sample takes them."""

import numpy as np

from obs_ros.core.model import Model
from obs_ros.core.periods import nearest, periods
from obs_ros.core.typing import Array


class ContinuousOutputs:
    """Successive outputs of sensors that wrap, made continuous.

    An output with a period (r,) is taken whole periods away, where it lies nearest the value that
    the observer had at the output before. So one false value does not lead the others astray.
    """

    def __init__(self, model: Model) -> None:
        self._period = periods(model.outputs)
        self._wraps = bool(self._period.any())
        self._expected = np.full(self._period.size, np.nan)

    def begin(self, expected: Array) -> None:
        """Start from the outputs (r,) that the observer expects first."""
        self._expected[:] = expected

    def taken(self, y: Array) -> Array:
        """Return outputs (r,) that follow on those before."""
        return nearest(y, self._expected, self._period) if self._wraps else y

    def note(self, y: Array, innovation: Array) -> None:
        """Take note of outputs as taken and of their innovations (r,); NaN = not measured."""
        if not self._wraps:
            return
        known = np.isfinite(y) & np.isfinite(innovation)
        self._expected[known] = y[known] - innovation[known]
