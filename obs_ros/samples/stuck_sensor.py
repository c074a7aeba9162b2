"""Sensors that are stuck: an output that repeats the very same value while it should not.

Numbers from a sensor with noise practically never repeat. Where they do, now and then, the sensor
rounds; where they do for long, and in between never, it says nothing any more.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from obs_ros.core.model import Model, names
from obs_ros.core.typing import Array

Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class StuckSettings:
    """Repeats that tell a stuck sensor: noise that rounds hardly ever repeats a value so often."""

    repeats: int = 10  # equal values in a row


DEFAULT = StuckSettings()


def stuck(y: Array, noisy: Sequence[bool] | Mask, settings: StuckSettings = DEFAULT) -> Mask:
    """Return which values (K, r) of a window are repeated by a stuck sensor; NaN = not measured.

    Stuck is a run of `settings.repeats` equal values, of an output whose noise is known (`noisy`
    (r,)) or while another output moves. An output that repeats some values for shorter is coarsely
    rounded, and never called stuck.
    """
    repeated = np.zeros(y.shape, dtype=bool)
    runs: list[list[tuple[int, int]]] = []
    for i, column in enumerate(y.T):
        runs.append(long_runs(column, settings.repeats))
        for first, last in runs[i]:
            repeated[first : last + 1, i] = True
    moving = np.isfinite(y) & ~repeated
    for i, found in enumerate(runs):
        for first, last in found:
            others = np.delete(moving[first : last + 1], i, axis=1)
            if not (noisy[i] or others.sum(axis=0).max(initial=0) > 1):
                repeated[first : last + 1, i] = False
    return repeated & np.isfinite(y)


def long_runs(column: Array, repeats: int) -> list[tuple[int, int]]:
    """Return first and last row of the runs of `repeats` equal values (K,) or more.

    There are none where shorter ones are found: then the sensor rounds. A run that the window cuts
    may be longer than is seen.
    """
    rows = np.flatnonzero(np.isfinite(column))
    if rows.size < repeats:
        return []
    begins = np.flatnonzero(np.diff(column[rows], prepend=np.nan) != 0.0)
    ends = np.append(begins[1:], rows.size) - 1
    lengths = ends - begins + 1
    inner = lengths[1:-1]
    if ((inner > 1) & (inner < repeats)).any():
        return []
    return [
        (int(rows[begin]), int(rows[end]))
        for begin, end in zip(begins, ends, strict=True)
        if end - begin + 1 >= repeats
    ]


def words(model: Model, outputs: Iterable[int]) -> str:
    """Say which outputs (by their numbers) are stuck, and what is done about it."""
    chosen = [names(model.outputs)[i] for i in outputs]
    sensors, repeat = ('sensors', 'repeat') if len(chosen) > 1 else ('sensor', 'repeats')
    found = ' and '.join(chosen)
    return f'look at the {sensors}: {found} {repeat} the same value, not taken for measured'


class Repeats:
    """The same, value after value, for observers that go from output to output."""

    def __init__(self, noisy: Sequence[bool], settings: StuckSettings = DEFAULT) -> None:
        self._noisy = tuple(noisy)
        self._repeats = settings.repeats
        self.clear()

    def clear(self) -> None:
        """Forget all values."""
        width = len(self._noisy)
        self._last = [float('nan')] * width
        self._runs = [0] * width
        self._coarse = [False] * width
        self.stuck: tuple[int, ...] = ()

    def note(self, values: Array) -> tuple[int, ...]:
        """Take the newest values (r,); return which outputs are stuck."""
        for i, value in enumerate(values.tolist()):
            if value == self._last[i]:
                self._runs[i] += 1
            elif value == value:  # a NaN is no value
                self._coarse[i] |= 1 < self._runs[i] < self._repeats
                self._last[i], self._runs[i] = value, 1
        self.stuck = ()
        if max(self._runs) >= self._repeats:
            long = [run >= self._repeats and not rounds
                    for run, rounds in zip(self._runs, self._coarse, strict=True)]  # fmt: skip
            moves = not all(long)
            self.stuck = tuple(i for i, is_long in enumerate(long)
                               if is_long and (moves or self._noisy[i]))  # fmt: skip
        return self.stuck
