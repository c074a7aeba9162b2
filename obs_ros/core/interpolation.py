"""Inputs between their samples: held, on straight lines, or at the mean of two neighbours."""

from collections.abc import Sequence
from typing import TypeVar, get_args

import numpy as np

from obs_ros.core.model import Interpolation
from obs_ros.core.typing import Array

Values = TypeVar('Values', float, Array)


def segment(
    kind: Interpolation, first: Values, last: Values, gap: Values, after: Values
) -> tuple[Values, Values | float]:
    """Return value and slope (per s) of an input `after` s past the first of two samples.

    Over the `gap` s from sample `first` to sample `last` the input is

    - `hold`: u = first;
    - `mean`: u = (first + last) / 2;
    - `linear`: u = first + slope * after, with slope = (last - first) / gap.
    """
    if kind == 'hold':
        return first, 0.0
    if kind == 'mean':
        return 0.5 * (first + last), 0.0
    slope = (last - first) / gap
    return first + slope * after, slope


def segments(t: Array, u: Array, kinds: Sequence[Interpolation]) -> tuple[Array, Array]:
    """Return value and slope (K, m) of every input from every node t (K,) on.

    Samples u (K, m) are NaN at nodes without one; the first node has one of each input. After its
    last sample an input holds it.
    """
    values, slopes = np.zeros((t.size, len(kinds))), np.zeros((t.size, len(kinds)))
    if np.isfinite(u).all():
        gap, none = np.diff(t), np.zeros(t.size - 1)
        values[-1:] = u[-1:]
        for i, kind in enumerate(kinds):
            values[:-1, i], slopes[:-1, i] = segment(kind, u[:-1, i], u[1:, i], gap, none)
        return values, slopes
    for i, kind in enumerate(kinds):
        known = np.flatnonzero(np.isfinite(u[:, i]))
        row = np.searchsorted(known, np.arange(t.size), side='right') - 1
        values[:, i] = u[known[row], i]
        inner = row < known.size - 1
        first, last = known[row[inner]], known[row[inner] + 1]
        values[inner, i], slopes[inner, i] = segment(
            kind, u[first, i], u[last, i], t[last] - t[first], t[inner] - t[first]
        )
    return values, slopes


def values_from(t: Array, u: Array, kinds: Sequence[Interpolation], time: float) -> Array:
    """Return samples (m,) with which a record may begin at a `time` (s): inputs go on as before.

    Samples u (K, m) at t (K,) are NaN at nodes without one. Of an input on straight lines it is the
    value then, of others the last sample; before the first one, that.
    """
    found = np.empty(len(kinds))
    for i, kind in enumerate(kinds):
        known = np.flatnonzero(np.isfinite(u[:, i]))
        row = max(int(np.searchsorted(t[known], time, side='right')) - 1, 0)
        first = known[row]
        found[i] = u[first, i]
        if kind == 'linear' and time > t[first] and row + 1 < known.size:
            last = known[row + 1]
            gap, after = t[last] - t[first], time - t[first]
            found[i], _ = segment(kind, u[first, i], u[last, i], gap, after)
    return found


def check_kinds(kinds: Sequence[str] | None, n_inputs: int) -> tuple[Interpolation, ...]:
    """Return one kind for each input, by default `hold`.

    Raises ValueError for another number of kinds, and for unknown ones.
    """
    known = {kind: kind for kind in get_args(Interpolation)}
    if kinds is None:
        return (known['hold'],) * n_inputs
    if len(kinds) != n_inputs:
        raise ValueError(f'{len(kinds)} interpolations given for {n_inputs} inputs')
    for kind in kinds:
        if kind not in known:
            raise ValueError(f'interpolation {kind!r} is none of {", ".join(known)}')
    return tuple(known[kind] for kind in kinds)
