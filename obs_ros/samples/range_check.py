"""Measurements, told apart from NaN, infinity and numbers far out of all bounds."""

import math
from collections.abc import MutableMapping, Sequence
from dataclasses import dataclass

import numpy as np

from obs_ros.core.model import Model, Variable
from obs_ros.core.record import Record
from obs_ros.core.typing import Array

LARGEST = 1e100  # where there is no box; sums of squares stay finite far beyond


@dataclass(frozen=True)
class RangeSettings:
    """Limits beyond which a number is no measurement, but a sentinel or a broken conversion.

    - `boxes`: widths of its box that a value may lie outside; a signal with the wrong unit, by a
      factor of 1000, must pass, to be seen as a mismatch.
    - `absurd`: times the spread of a window, and 1; beside such a value all others are lost in
      rounding.
    """

    boxes: float = 1e6
    absurd: float = 1e15


DEFAULT = RangeSettings()
COUNTS = {
    'nan': 'samples with some entries NaN or infinite, which count as not measured',
    'all_nan': 'samples dropped: every entry NaN or infinite',
    'huge': f'samples with entries beyond {DEFAULT.boxes:g} times their range, which count as not '
    'measured',
}

Limits = Sequence[tuple[float, float]]


def limits(
    model: Model, variables: Sequence[Variable], settings: RangeSettings = DEFAULT
) -> Limits:
    """Return the limits of the measurements of each input or output.

    The range of an output without bounds is that of the state of its name, if there is one; without
    any bounds it is set by the nominal value.
    """
    states = {variable.name: variable for variable in model.states}
    boxes = settings.boxes
    return [_limits(variable, states.get(variable.name), boxes) for variable in variables]


def anything(width: int) -> Limits:
    """Return limits that only numbers exceed whose squares have no sum."""
    return [(-LARGEST, LARGEST)] * width


def measured(values: Array, limits: Limits, counts: MutableMapping[str, int]) -> Array | None:
    """Return values (n,), NaN for those that are no measurements; None if none is. Count them."""
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


def without_absurd(record: Record, settings: RangeSettings = DEFAULT) -> tuple[Record, int]:
    """Return a window without outputs that are absurd by its own spread, and how many there were.

    The spread of an output is the median of the deviations from its median that are not zero: most
    of a signal may be zero, or one of two levels.
    """
    if not (np.abs(record.y) > settings.absurd).any():  # NaN is not
        return record, 0
    y = record.y.copy()
    for column in y.T:
        known = column[np.isfinite(column)]
        off = np.abs(column - np.median(known)) if known.size else np.zeros(column.size)
        usual = np.abs(known - np.median(known)) if known.size else known
        spread = np.median(usual[usual > 0.0]) if (usual > 0.0).any() else np.inf
        column[off > settings.absurd * max(spread, 1.0)] = np.nan
    absurd = int(np.count_nonzero(np.isnan(y) & np.isfinite(record.y)))
    return (record.with_outputs(y), absurd) if absurd else (record, 0)


def _limits(variable: Variable, state: Variable | None, boxes: float) -> tuple[float, float]:
    for each in (variable, state):
        if each is not None and math.isfinite(each.upper - each.lower):
            reach = boxes * (each.upper - each.lower)
            return max(each.lower - reach, -LARGEST), min(each.upper + reach, LARGEST)
    if variable.nominal:
        reach = min(boxes * abs(variable.nominal), LARGEST)
        return -reach, reach
    return -LARGEST, LARGEST
