"""Inputs as they are known live: piece by piece from their own stamps."""

import math
from bisect import bisect_left, bisect_right
from collections.abc import Sequence

import numpy as np

from obs_ros.core.interpolation import segment
from obs_ros.core.model import Model
from obs_ros.core.saturation import applied
from obs_ros.core.typing import Array
from obs_ros.integration.grid import longest_step
from obs_ros.integration.path import Path


class InputHistory:
    """Samples of the inputs, sorted by stamp, from the one in force at the newest output on.

    Between two samples an input does as its Variable says; after the last one that is known it
    holds. An entry that is NaN keeps the value that it had in the sample before. Actuators clip
    their inputs to the ranges that they have. To a discrete model inputs change at nodes only.
    """

    def __init__(self, model: Model) -> None:
        width = len(model.inputs)
        self._inputs = tuple(model.inputs)
        self._kinds = [variable.interpolation for variable in model.inputs]
        self._moving = [i for i, kind in enumerate(self._kinds) if kind != 'hold']
        self.longest = longest_step(model)  # s, of the steps of paths
        self._period = None if model.period is None else 1e9 * model.period  # ns
        self._rows = 0
        self._room(8, width)
        self._width = width
        self.clear()

    def __len__(self) -> int:
        return len(self._stamps)

    def clear(self) -> None:
        """Forget all samples."""
        self._stamps: list[int] = []
        self._measured: list[Array] = []  # as they came
        self._values: list[Array] = []  # with those of earlier samples in the place of NaN

    def known_at(self, stamp: int) -> bool:
        """Whether every input has a value at `stamp` (ns); a plant without inputs knows all."""
        row = bisect_right(self._stamps, stamp) - 1
        return not self._width or (row >= 0 and _whole(self._values[row]))

    def add(self, stamp: int, values: Array) -> bool:
        """Sort in a sample, values (m,) at `stamp` (ns); False if its stamp is there already."""
        values = applied(self._inputs, values)
        row = bisect_left(self._stamps, stamp)
        if row < len(self) and self._stamps[row] == stamp:
            return False
        self._stamps.insert(row, stamp)
        self._measured.insert(row, values)
        self._values.insert(row, values)
        for k in range(row, len(self)):
            measured = self._measured[k]
            if not _whole(measured):
                before = self._values[k - 1] if k else measured
                self._values[k] = np.where(np.isnan(measured), before, measured)
            elif k > row:
                break  # it owes nothing to those before it
        return True

    def drop(self, count: int) -> None:
        """Forget the `count` oldest samples, but not the values that hold on from them."""
        del self._stamps[:count], self._measured[:count], self._values[:count]
        self._measured[:1] = self._values[:1]

    def drop_before(self, stamp: int) -> None:
        """Forget the samples older than the one in force at `stamp` (ns)."""
        passed = bisect_right(self._stamps, stamp) - 1
        if passed > 0:
            self.drop(passed)

    def path(self, begin: int, end: int) -> Path:
        """Return the path from stamp `begin` to stamp `end` (ns), and forget what lies before."""
        nodes = [begin, *self._between(begin, end), end]
        pieces = len(nodes) - 1
        if pieces >= self._rows:
            self._room(2 * pieces, self._width)
        for k, stamp in enumerate(nodes):
            self._t[k] = stamp / 1e9
            if self._width:
                self._lay(k, stamp)
        for k in range(pieces):
            # Not from t: at the size of today's dates that resolves 0.24 us only.
            dt = (nodes[k + 1] - nodes[k]) / 1e9
            self._dt[k] = dt
            self._steps[k] = 1 if self._period else max(1, math.ceil(dt / self.longest))
        self.drop_before(end)
        return Path(pieces, self._t, self._dt, self._steps, self._u, self._slope)

    def _between(self, begin: int, end: int) -> Sequence[int]:
        """Return the stamps (ns) between two at which a piece of the path begins."""
        if self._period is None:
            return [stamp for stamp in self._stamps if begin < stamp < end]
        periods = max(1, round((end - begin) / self._period))
        return [begin + k * (end - begin) // periods for k in range(1, periods)]

    def _lay(self, k: int, stamp: int) -> None:
        """Write value and slope of the inputs from node k on."""
        row = max(0, bisect_right(self._stamps, stamp) - 1)
        self._u[k] = self._values[row]
        if not self._moving:
            return
        self._slope[k] = 0.0
        if row + 1 == len(self._stamps):
            return
        first, last = self._values[row], self._values[row + 1]
        gap = (self._stamps[row + 1] - self._stamps[row]) / 1e9
        after = (stamp - self._stamps[row]) / 1e9
        for i in self._moving:
            self._u[k, i], self._slope[k, i] = segment(
                self._kinds[i], float(first[i]), float(last[i]), gap, after
            )

    def _room(self, rows: int, width: int) -> None:
        self._rows = rows
        self._t, self._dt = np.zeros(rows), np.zeros(rows)
        self._steps = np.ones(rows, dtype=np.int64)
        self._u, self._slope = np.zeros((rows, width)), np.zeros((rows, width))


def _whole(values: Array) -> bool:
    """Whether no value (m,) is NaN; over so few, plain Python is faster than NumPy."""
    return math.isfinite(sum(values.tolist()))
