"""Samples of one stream in stamp order, in arrays of bounded size."""

import numpy as np

from obs_ros.core.typing import Array, IntArray

# Any ROS stamp (int32 seconds) lies within, and sums of two still fit an int64.
STAMP_LIMIT = 2**62
FIRST_ROWS = 64


class Stream:
    """At most `capacity` + 1 samples, each a stamp (ns) and `width` values, sorted by stamp.

    They lie in a stretch of two arrays that moves to the right as samples come and go, and back to
    the left when it reaches their end: always contiguous, and O(1) per sample on average. The
    arrays double when needed, up to 2 `capacity` + 2 rows. The one sample above `capacity` leaves
    the caller the choice which to drop.
    """

    def __init__(self, width: int, capacity: int) -> None:
        self.width = width
        self._most_rows = 2 * capacity + 2
        rows = min(FIRST_ROWS, self._most_rows)
        self._stamps: IntArray = np.empty(rows, dtype=np.int64)
        self._values: Array = np.empty((rows, width))
        self._begin = self._stop = 0

    def __len__(self) -> int:
        return self._stop - self._begin

    @property
    def stamps(self) -> IntArray:
        """Stamps of the stored samples (len,), a view."""
        return self._stamps[self._begin : self._stop]

    @property
    def values(self) -> Array:
        """Values of the stored samples (len, width), a view."""
        return self._values[self._begin : self._stop]

    @property
    def nbytes(self) -> int:
        """Size of the arrays in bytes, used or not."""
        return self._stamps.nbytes + self._values.nbytes

    def add(self, stamp: int, values: Array) -> bool:
        """Sort in a sample; False if its stamp is there already."""
        row = len(self)
        if row and stamp <= self._stamps[self._stop - 1]:
            row = int(self.stamps.searchsorted(stamp))
            if self.stamps[row] == stamp:
                return False
        if self._stop == len(self._stamps):
            self._make_room()
        self._stop += 1
        if row < len(self) - 1:
            for array in (self.stamps, self.values):
                array[row + 1 :] = array[row:-1]
        self._stamps[self._begin + row] = stamp
        self._values[self._begin + row] = values
        return True

    def fill(self, stamps: IntArray, values: Array) -> None:
        """Take samples, stamps (K,) that rise and values (K, width), in the place of all stored."""
        self.clear()
        self._stop = stamps.size
        self._stamps = np.append(stamps, 0)  # with room for one more
        self._values = np.vstack([values, np.zeros((1, self.width))])

    def drop(self, count: int) -> None:
        """Drop the `count` oldest samples."""
        self._begin += count

    def drop_until(self, stamp: int) -> int:
        """Drop the samples up to and including `stamp`; return how many."""
        count = self.count_until(stamp)
        if count:
            self.drop(count)
        return count

    def count_until(self, stamp: int) -> int:
        """Return how many stored samples are not newer than `stamp`."""
        return int(self.stamps.searchsorted(stamp, side='right'))

    def clear(self) -> None:
        """Forget all samples; the arrays stay."""
        self._begin = self._stop = 0

    def _make_room(self) -> None:
        count = len(self)
        stamps, values = self._stamps, self._values
        if 2 * count > len(stamps):
            rows = min(2 * len(stamps), self._most_rows)
            self._stamps = np.empty(rows, dtype=np.int64)
            self._values = np.empty((rows, self.width))
        self._stamps[:count] = stamps[self._begin : self._stop]
        self._values[:count] = values[self._begin : self._stop]
        self._begin, self._stop = 0, count


class InputStream(Stream):
    """A stream whose values stay known between samples: it remembers the last one it dropped.

    A NaN entry says nothing about its column. `known_since` is the stamp (ns) from which every
    column has a value, None until there is one. It rises when samples are dropped, because only
    the last value of each column survives.
    """

    def __init__(self, width: int, capacity: int) -> None:
        super().__init__(width, capacity)
        self.clear()

    def clear(self) -> None:
        """Forget all samples and all that is remembered of dropped ones."""
        super().clear()
        self._since: IntArray = np.full(self.width, STAMP_LIMIT)
        self._held: Array = np.full(self.width, np.nan)
        self._held_stamps: IntArray = np.full(self.width, -STAMP_LIMIT)
        self.known_since: int | None = None if self.width else -STAMP_LIMIT

    def add(self, stamp: int, values: Array) -> bool:
        """Sort in a sample; False if its stamp is there already."""
        added = super().add(stamp, values)
        if added and (self.known_since is None or stamp < self.known_since):
            self._note(stamp, values)
        return added

    def fill(self, stamps: IntArray, values: Array) -> None:
        """Take samples, stamps (K,) that rise and values (K, width), in the place of all stored."""
        super().fill(stamps, values)
        known = ~np.isnan(values)
        some = known.any(axis=0)
        if stamps.size:
            self._since[some] = stamps[known.argmax(axis=0)[some]]
        self._update_known_since()

    def drop(self, count: int) -> None:
        """Drop the `count` oldest samples, remembering the last value of each column."""
        values = self.values[:count]
        known = ~np.isnan(values)
        last = count - 1 - known[::-1].argmax(axis=0)
        latest = values[last, np.arange(self.width)]
        self._hold(self.stamps[last], latest)
        super().drop(count)

    def remember(self, stamp: int, values: Array) -> bool:
        """Take note of a sample older than all stored ones; False if it is of no use any more."""
        return self._hold(np.full(self.width, stamp), values)

    def before(self, stamp: int, column: int) -> tuple[int, float]:
        """Return stamp and value of the last value at or before `stamp`; NaN if there is none."""
        count = self.count_until(stamp)
        rows = np.flatnonzero(~np.isnan(self.values[:count, column]))
        if rows.size:
            return int(self.stamps[rows[-1]]), float(self.values[rows[-1], column])
        return int(self._held_stamps[column]), float(self._held[column])

    def after(self, stamp: int, column: int) -> tuple[int, float]:
        """Return stamp and value of the first value after `stamp`; NaN if there is none."""
        count = self.count_until(stamp)
        rows = count + np.flatnonzero(~np.isnan(self.values[count:, column]))
        if rows.size:
            return int(self.stamps[rows[0]]), float(self.values[rows[0], column])
        return STAMP_LIMIT, float('nan')

    def _hold(self, stamps: IntArray, values: Array) -> bool:
        newer = ~np.isnan(values) & (stamps > self._held_stamps)
        self._held[newer] = values[newer]
        self._held_stamps[newer] = stamps[newer]
        self._update_known_since()
        return bool(newer.any())

    def _note(self, stamp: int, values: Array) -> None:
        self._since[~np.isnan(values) & (stamp < self._since)] = stamp
        self._update_known_since()

    def _update_known_since(self) -> None:
        if self.width:
            since = int(np.maximum(self._since, self._held_stamps).max())
            self.known_since = since if since < STAMP_LIMIT else None
