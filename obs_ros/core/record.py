"""A stretch of measured inputs and outputs on one time axis."""

from dataclasses import dataclass
from operator import index

import numpy as np
from numpy.typing import ArrayLike

from obs_ros.core.typing import Array


@dataclass(frozen=True)
class Sample:
    """One message's measurement: `stamp` in ns, outputs y (r,) or inputs u (m,)."""

    stamp: int
    y: Array | None = None
    u: Array | None = None


# The arrays have no truth value to compare records by, so a record equals only itself.
@dataclass(frozen=True, eq=False, init=False)
class Record:
    """Samples of a stretch of time: t (K,) in s, rising; u (K, m); y (K, r); NaN = not measured.

    A single input or output may come as (K,); `u` is None or empty for a plant without inputs.
    The arrays are copied and read-only. `stamp` is the newest output's stamp in ns, where the
    samples came with stamps. `past` are the inputs before, where they may act late: times (L,) that
    end with t[0], and inputs (L, m), as u with a value of each at the first.

    Raises ValueError for wrong shapes, fewer than two samples, times that do not rise or are not
    finite, infinite values, no measured output at all, and an input without a value at the first
    sample.
    """

    t: Array
    u: Array
    y: Array
    stamp: int | None = None
    past: tuple[Array, Array] | None = None

    def __init__(
        self,
        t: ArrayLike,
        u: ArrayLike | None,
        y: ArrayLike,
        stamp: int | None = None,
        past: tuple[Array, Array] | None = None,
    ) -> None:
        times = np.array(t, dtype=np.float64)
        check_times(times)
        inputs = columns('u', u, times.size)
        outputs = columns('y', y, times.size)
        missing = np.flatnonzero(np.isnan(inputs[0]))
        if missing.size:
            raise ValueError(
                f'input column {missing[0]} has no value at the first sample: start the record '
                'where every input is known'
            )
        if np.isnan(outputs).all():
            raise ValueError('y has no measured value: a record needs at least one')
        for name, array in (('t', times), ('u', inputs), ('y', outputs)):
            array.flags.writeable = False
            object.__setattr__(self, name, array)
        object.__setattr__(self, 'stamp', None if stamp is None else index(stamp))
        object.__setattr__(self, 'past', past)

    def with_outputs(self, y: Array) -> 'Record':
        """Return the record with other outputs (K, r), and the stamp of the newest of them."""
        stamp = self.stamp
        if stamp is not None:
            newest, left = (
                float(self.t[np.isfinite(each).any(axis=1)][-1]) for each in (self.y, y)
            )
            stamp -= round((newest - left) * 1e9)
        return Record(self.t, self.u, y, stamp, self.past)


def check_times(t: Array) -> None:
    """Raise ValueError unless t (K,) holds two or more finite times in s that strictly rise."""
    if t.ndim != 1 or t.size < 2:
        raise ValueError(f't must hold at least two times in one dimension, not shape {t.shape}')
    wrong = np.flatnonzero(~np.isfinite(t))
    if wrong.size:
        raise ValueError(f't[{wrong[0]}] is {t[wrong[0]]}: every time must be a finite number')
    wrong = np.flatnonzero(np.diff(t) <= 0)
    if wrong.size:
        k = int(wrong[0])
        raise ValueError(
            f't[{k + 1}] = {t[k + 1]} s does not come after t[{k}] = {t[k]} s: '
            'times must strictly rise'
        )


def columns(name: str, values: ArrayLike | None, rows: int) -> Array:
    """Return a copy of the values as (rows, columns); raises ValueError where that is impossible.

    None and empty mean no columns; infinite values are refused.
    """
    array = np.array(() if values is None else values, dtype=np.float64, order='C')
    if array.size == 0 and array.shape[0] in (0, rows):
        return np.empty((rows, 0))
    if array.ndim not in (1, 2):
        raise ValueError(f'{name} must have shape ({rows},) or ({rows}, n), not {array.shape}')
    if array.shape[0] != rows:
        raise ValueError(f'{name} has {array.shape[0]} rows but t has {rows}')
    array = array.reshape(rows, -1)
    infinite = np.argwhere(np.isinf(array))
    if infinite.size:
        row, column = infinite[0]
        raise ValueError(
            f'{name}[{row}, {column}] is {array[row, column]}: use NaN where nothing was measured'
        )
    return array
