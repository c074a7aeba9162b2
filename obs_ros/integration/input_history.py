"""Inputs as they are known live: piece by piece from their own stamps."""

import math
from bisect import bisect_right

import numpy as np

from obs_ros.core.model import Model
from obs_ros.core.typing import Array
from obs_ros.integration.grid import longest_step
from obs_ros.integration.path import Path

MOST = 4096  # samples that wait for an output


class HeldInputs:
    """Samples of the inputs, from the one in force at the newest output on.

    Between two samples an input does as its Variable says; after the last one that is known it
    holds. An entry that is NaN keeps its last value.
    """

    def __init__(self, model: Model) -> None:
        width = len(model.inputs)
        self._kinds = [variable.interpolation for variable in model.inputs]
        self._moving = any(kind != 'hold' for kind in self._kinds)
        self._longest = longest_step(model)
        self._rows = 0
        self._room(8, width)
        self._width = width
        self.clear()

    def clear(self) -> None:
        """Forget all samples."""
        # A plant without inputs knows all of them, always.
        self._stamps: list[int] = []
        self._values: list[Array] = []
        self._latest = np.full(self._width, np.nan)

    def known_at(self, stamp: int) -> bool:
        """Whether every input has a value at `stamp` (ns)."""
        return not self._width or (bool(self._stamps) and self._stamps[0] <= stamp)

    def add(self, stamp: int, values: Array) -> bool:
        """Store a sample not older than the others; False if the oldest had to go for it."""
        if math.isfinite(sum(values.tolist())):
            self._latest = values
        else:
            self._latest = np.where(np.isnan(values), self._latest, values)
            if np.isnan(self._latest).any():
                return True
        if self._stamps and self._stamps[-1] >= stamp:
            self._values[-1] = self._latest
            return True
        self._stamps.append(stamp)
        self._values.append(self._latest)
        if len(self._stamps) > MOST:
            del self._stamps[0], self._values[0]
            return False
        return True

    def path(self, begin: int, end: int) -> Path:
        """Return the path from stamp `begin` to stamp `end` (ns), and forget what lies before."""
        nodes = [begin, *(stamp for stamp in self._stamps if begin < stamp < end), end]
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
            self._steps[k] = max(1, math.ceil(dt / self._longest))
        passed = bisect_right(self._stamps, end) - 1
        if passed > 0:
            del self._stamps[:passed], self._values[:passed]
        return Path(pieces, self._t, self._dt, self._steps, self._u, self._slope)

    def _lay(self, k: int, stamp: int) -> None:
        """Write value and slope of the inputs from node k on."""
        row = max(0, bisect_right(self._stamps, stamp) - 1)
        self._u[k] = self._values[row]
        if not self._moving:
            return
        self._slope[k] = 0.0
        if row + 1 == len(self._stamps):
            return
        gap = (self._stamps[row + 1] - self._stamps[row]) / 1e9
        for i, kind in enumerate(self._kinds):
            if kind == 'hold':
                continue
            rise = self._values[row + 1][i] - self._values[row][i]
            if kind == 'mean':
                self._u[k, i] += 0.5 * rise
            else:
                self._slope[k, i] = rise / gap
                self._u[k, i] += rise * ((stamp - self._stamps[row]) / 1e9) / gap

    def _room(self, rows: int, width: int) -> None:
        self._rows = rows
        self._t, self._dt = np.zeros(rows), np.zeros(rows)
        self._steps = np.ones(rows, dtype=np.int64)
        self._u, self._slope = np.zeros((rows, width)), np.zeros((rows, width))
