"""The values that an observer starts from."""

from collections.abc import Mapping

from obs_ros.core.model import names
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
