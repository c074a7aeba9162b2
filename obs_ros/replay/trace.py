"""Numbers over time, thinned out so that a picture of any recording is kept in little memory."""

from array import array
from collections.abc import Iterable

import numpy as np

from obs_ros.core.typing import Array, IntArray

MOST = 4000  # rows


class Trace:
    """Rows of numbers by stamp (ns), in the order in which they come.

    Up to 2 MOST rows are kept: when there are as many, every other one goes, and from then on only
    every second, fourth, ... of those that come is taken.
    """

    def __init__(self, width: int) -> None:
        self.width = width
        self._stamps = array('q')
        self._numbers = array('d')
        self._stride, self._seen = 1, 0

    def add(self, stamp: int, row: Iterable[float]) -> None:
        """Take a row of `width` numbers."""
        if self._seen % self._stride == 0:
            self._stamps.append(stamp)
            self._numbers.extend(row)
        self._seen += 1
        if len(self._stamps) >= 2 * MOST:
            self._numbers = array('d', self.rows[::2].ravel())
            self._stamps = self._stamps[::2]
            self._stride *= 2

    def __len__(self) -> int:
        return len(self._stamps)

    @property
    def stamps(self) -> IntArray:
        """The stamps (K,) in ns."""
        return np.array(self._stamps, dtype=np.int64)

    @property
    def rows(self) -> Array:
        """The rows (K, width)."""
        return np.array(self._numbers, dtype=np.float64).reshape(-1, self.width)
