"""The values that an observer starts from, and the bounds that it keeps."""

from collections.abc import Mapping

import numpy as np

from obs_ros.core.model import Model, names
from obs_ros.core.periods import lasting_bounds
from obs_ros.core.typing import Array
from obs_ros.inference.parameterisation import Unknowns


def initial_values(unknowns: Unknowns, given: Mapping[str, float]) -> Array:
    """Return states and parameters (n + q,) to start from; `given` are some of them by name.

    The others are at a prior's mean, their nominal value, or in the middle of their box. Raises
    ValueError for a name that is not estimated.
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
