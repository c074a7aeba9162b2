"""The values that a recursive observer starts from, and the bounds that it keeps."""

from collections.abc import Mapping

import numpy as np

from obs_ros.core.model import Model, names
from obs_ros.core.periods import lasting_bounds, nearest, periods
from obs_ros.core.typing import Array
from obs_ros.inference.parameterisation import Unknowns


def initial_values(unknowns: Unknowns, given: Mapping[str, float]) -> Array:
    """Return states and parameters (n + q,) to start from.

    Those not given start at their prior's mean, nominal value, or the middle of their box. Raises
    ValueError for a given value that cannot be one.
    """
    model, scale = unknowns.model, unknowns.scale
    values = unknowns.given.copy()
    for i, low, high in zip(unknowns.index, scale.lower, scale.upper, strict=True):
        expected = (model.variables[i].prior or (model.variables[i].nominal,))[0]
        values[i] = 0.5 * (low + high) if expected is None else min(max(expected, low), high)
    order = list(names(model.variables))
    unknowns.check_initial(given)
    values[[order.index(name) for name in given]] = list(given.values())
    return values


def kept_bounds(
    model: Model, bounds: Mapping[str, tuple[float, float]] | None
) -> tuple[Array, Array]:
    """Return lower and upper bounds (n + q,) of all along: the model's, or those given by name."""
    limits = [
        lasting_bounds(v) if v.period else (bounds or {}).get(v.name, (v.lower, v.upper))
        for v in model.variables
    ]
    lower, upper = np.array(limits, dtype=np.float64).T.copy()
    return lower, upper


class ContinuousOutputs:
    """Successive outputs of sensors that wrap, made continuous.

    An output with a period (r,) is taken whole periods away, where it lies nearest the value that
    the observer had at the output before. So one false value does not lead the others astray.
    """

    def __init__(self, model: Model) -> None:
        self._period = periods(model.outputs)
        self._expected = np.full(self._period.size, np.nan)

    def begin(self, expected: Array) -> None:
        """Start from the outputs (r,) that the observer expects first."""
        self._expected[:] = expected

    def taken(self, y: Array) -> Array:
        """Return outputs (r,) that follow on those before."""
        return nearest(y, self._expected, self._period)

    def note(self, y: Array, innovation: Array) -> None:
        """Take note of outputs as taken and of their innovations (r,); NaN = not measured."""
        if not self._period.any():
            return
        known = np.isfinite(y) & np.isfinite(innovation)
        self._expected[known] = y[known] - innovation[known]
