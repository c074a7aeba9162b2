"""Telling measurements from what cannot be any: NaN, infinity, numbers far out of all bounds."""

import math
from collections.abc import MutableMapping, Sequence

import numpy as np

from obs_ros.model import Model, Variable
from obs_ros.typing import Array

BOXES = 1e6  # widths of its box that a value may lie outside
LARGEST = 1e100  # where there is no box; sums of squares stay finite far beyond

COUNTS = {
    'nan': 'samples with some entries NaN or infinite, which count as not measured',
    'all_nan': 'samples dropped: every entry NaN or infinite',
    'huge': f'samples with entries beyond {BOXES:g} times their range, which count as not measured',
}

Limits = Sequence[tuple[float, float]]


def limits(model: Model, variables: Sequence[Variable]) -> Limits:
    """Return for each input or output between what its measurements lie.

    The range of an output without bounds is that of the state of its name, if there is one; without
    any bounds it is set by the nominal value.
    """
    states = {variable.name: variable for variable in model.states}
    return [_limits(variable, states.get(variable.name)) for variable in variables]


def anything(width: int) -> Limits:
    """Return limits that only what cannot be squared and summed exceeds."""
    return [(-LARGEST, LARGEST)] * width


def measured(values: Array, limits: Limits, counts: MutableMapping[str, int]) -> Array | None:
    """Return values (n,) with NaN for what is no measurement, None if nothing is left; count it."""
    # Over so few values plain Python is ten times faster than NumPy; a NaN is in no range.
    pairs = zip(values.tolist(), limits, strict=True)
    if all(low <= value <= high for value, (low, high) in pairs):
        return values
    finite = np.isfinite(values)
    if not finite.any():
        counts['all_nan'] += 1
        return None
    low, high = np.array(limits).T
    right = finite & (values >= low) & (values <= high)
    counts['huge'] += not np.array_equal(right, finite)
    if not right.any():
        return None
    counts['nan'] += not finite.all()
    return np.where(right, values, np.nan)


def _limits(variable: Variable, state: Variable | None) -> tuple[float, float]:
    for each in (variable, state):
        if each is not None and math.isfinite(each.upper - each.lower):
            reach = BOXES * (each.upper - each.lower)
            return max(each.lower - reach, -LARGEST), min(each.upper + reach, LARGEST)
    if variable.nominal:
        reach = min(BOXES * abs(variable.nominal), LARGEST)
        return -reach, reach
    return -LARGEST, LARGEST
