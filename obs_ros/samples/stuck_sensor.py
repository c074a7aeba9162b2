"""Sensors that are stuck: an output that repeats the very same value while it should not.

Numbers from a sensor with noise practically never repeat. Where they do, now and then, the sensor
rounds; where they do for long, and in between never, it says nothing any more. A sensor whose
rounding is coarser than its noise repeats values as long as it likes, and so does one at the end of
its range.
"""

import math
from collections import deque
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from obs_ros.core.model import Model, Variable, names
from obs_ros.core.saturation import has_range, unsaturated
from obs_ros.core.typing import Array
from obs_ros.samples.resolution import Resolutions

Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class StuckSettings:
    """Repeats that tell a stuck sensor.

    - `repeats`: equal values in a row; noise that is rounded hardly ever repeats one so often;
    - `remembered`: latest values, by which those who go from output to output know a step.
    """

    repeats: int = 10
    remembered: int = 500


DEFAULT = StuckSettings()


def stuck(
    y: Array,
    noisy: Sequence[bool] | Mask,
    settings: StuckSettings = DEFAULT,
    resolutions: Resolutions | None = None,
    noise: Array | None = None,
) -> Mask:
    """Return which values (K, r) of a window are repeated by a stuck sensor; NaN = not measured.

    Stuck is a run of `settings.repeats` equal values, of an output whose noise is known (`noisy`
    (r,)) or while another output moves. An output that repeats some values for shorter is coarsely
    rounded, and never called stuck; nor is one that repeats no more values than its sensor, by its
    step of `resolutions` and its `noise` (r,), NaN = not given, does by itself.
    """
    repeated = np.zeros(y.shape, dtype=bool)
    runs: list[list[tuple[int, int]]] = []
    for i, column in enumerate(y.T):
        found = long_runs(column, settings.repeats)
        if found and resolutions is not None:
            given = float('nan') if noise is None else float(noise[i])
            natural = resolutions.natural_repeats(i, _without(column, found), given)
            found = [run for run in found if _length(column, run) > natural]
        runs.append(found)
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
    known = column[rows]
    if rows.size < repeats or not (known[1:] == known[:-1]).any():
        return []
    begins = np.flatnonzero(np.diff(known, prepend=np.nan) != 0.0)
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


def _length(column: Array, run: tuple[int, int]) -> int:
    """Return how many values a run has."""
    return int(np.isfinite(column[run[0] : run[1] + 1]).sum())


def _without(column: Array, runs: Sequence[tuple[int, int]]) -> Array:
    """Return the measured values (M,) outside the runs."""
    known = np.isfinite(column)
    for first, last in runs:
        known[first : last + 1] = False
    return column[known]


def words(model: Model, outputs: Iterable[int]) -> str:
    """Say which outputs (by their numbers) are stuck, and what is done about it."""
    chosen = [names(model.outputs)[i] for i in outputs]
    sensors, repeat = ('sensors', 'repeat') if len(chosen) > 1 else ('sensor', 'repeats')
    found = ' and '.join(chosen)
    return f'look at the {sensors}: {found} {repeat} the same value, not taken for measured'


class Repeats:
    """The same, value after value, for observers that go from output to output."""

    def __init__(
        self,
        noisy: Sequence[bool],
        settings: StuckSettings = DEFAULT,
        outputs: Sequence[Variable] | None = None,
        noise: Sequence[float] | None = None,
    ) -> None:
        """Tell stuck `outputs` whose noise is known (`noisy` (r,)); see `stuck`.

        `noise` (r,) are the deviations that are given, NaN for the others.
        """
        width = len(noisy)
        self._noisy, self._settings = tuple(noisy), settings
        self._outputs = outputs or [Variable(f'y{i}') for i in range(width)]
        self._noise = [math.nan] * width if noise is None else list(noise)
        self._ranged = has_range(self._outputs)
        self.resolutions = Resolutions(self._outputs)
        self.clear()

    @classmethod
    def of(cls, model: Model, deviations: Sequence[float]) -> 'Repeats':
        """Return those of a model's outputs, with the deviations (r,) given for their noise."""
        return cls([deviation == deviation for deviation in deviations], DEFAULT, model.outputs,
                   deviations)  # fmt: skip

    def clear(self) -> None:
        """Forget all values, but not the steps that were learned."""
        width = len(self._noisy)
        self._last = [math.nan] * width
        self._runs = [0] * width
        self._natural = [0.0] * width  # equal values in a row that rounding leaves, of the last run
        self._moving = [deque[float](maxlen=self._settings.remembered) for _ in range(width)]
        self._coarse = [False] * width
        self.stuck: tuple[int, ...] = ()

    def note(self, values: Array) -> tuple[int, ...]:
        """Take the newest values (r,); return which outputs are stuck."""
        repeats = self._settings.repeats
        if self._ranged:
            values = unsaturated(self._outputs, values)
        self.resolutions.note(values)
        for i, value in enumerate(values.tolist()):
            if value == self._last[i]:
                self._runs[i] += 1
            elif value == value:  # a NaN is no value
                self._coarse[i] |= 1 < self._runs[i] < repeats
                self._last[i], self._runs[i] = value, 1
            if self._runs[i] < repeats:
                self._moving[i].append(value)
            elif self._runs[i] == repeats:
                moving = np.array(self._moving[i])
                moving = moving[np.isfinite(moving)]
                self._natural[i] = self.resolutions.natural_repeats(i, moving, self._noise[i])
        self.stuck = ()
        if max(self._runs) >= repeats:
            long = [run >= repeats and run > natural and not rounds
                    for run, natural, rounds
                    in zip(self._runs, self._natural, self._coarse, strict=True)]  # fmt: skip
            moves = not all(long)
            self.stuck = tuple(i for i, is_long in enumerate(long)
                               if is_long and (moves or self._noisy[i]))  # fmt: skip
        return self.stuck
