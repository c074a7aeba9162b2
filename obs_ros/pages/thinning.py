"""Numbers over time in bounded memory: thinned where there are many, extremes kept."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from obs_ros.core.typing import Array, BoolArray, IntArray

FACTOR = 4  # rows of a level that become one of the next
BLOCK = 64  # rows of a level that do so at once, which costs hardly more than four


@dataclass(frozen=True)
class ThinningSettings:
    """Sizes of what is kept: a row costs 32 bytes a column.

    With 600 rows and 10 levels the coarsest holds 1.6e8 samples or more, 43 h at 1 kHz.
    """

    rows: int = 600  # kept of each level at least, and up to twice as many; at least BLOCK
    levels: int = 10
    # Steps of the newest rows that a stamp may lie back: further, and it is of a new timeline.
    late: float = 100.0


SETTINGS = ThinningSettings()


class Extremes(NamedTuple):
    """Buckets of rows: least and largest of each column (K, w), NaN where there was no number.

    `low_at` and `high_at` (K, w) are the stamps (ns) at which these were; all rows of a bucket are
    from `begin` to `end` (K, 1).
    """

    low: Array
    high: Array
    low_at: IntArray
    high_at: IntArray
    begin: IntArray
    end: IntArray

    def merged(self, size: int) -> 'Extremes':
        """Return buckets of `size` of these each, the last one with what is left."""
        count = -(-len(self.low) // size)
        room = count * size - len(self.low)
        low, low_at = _blocks(self.low, self.low_at, count, room)
        high, high_at = _blocks(self.high, self.high_at, count, room)
        least = np.where(np.isnan(low), np.inf, low).argmin(axis=1)[:, None]
        most = np.where(np.isnan(high), -np.inf, high).argmax(axis=1)[:, None]
        return Extremes(
            np.take_along_axis(low, least, axis=1)[:, 0],
            np.take_along_axis(high, most, axis=1)[:, 0],
            np.take_along_axis(low_at, least, axis=1)[:, 0],
            np.take_along_axis(high_at, most, axis=1)[:, 0],
            _filled(self.begin, count, room).min(axis=1),
            _filled(self.end, count, room).max(axis=1),
        )

    def part(self, kept: 'slice | BoolArray') -> 'Extremes':
        """Return some of the buckets."""
        return Extremes._make(each[kept] for each in self)

    def column(self, place: int) -> tuple[IntArray, Array]:
        """Return stamps (P,), which rise, and values (P,) of one column: two of a bucket at most.

        A bucket without numbers gives one NaN, so that a line is interrupted there.
        """
        low, high, low_at, high_at = (each[:, place] for each in self[:4])
        second = high_at != low_at
        stamps = np.concatenate([low_at, high_at[second]])
        values = np.concatenate([low, high[second]])
        order = np.argsort(stamps, kind='stable')
        return stamps[order], values[order]


class _Level:
    """The newest rows of one resolution, in arrays that grow to twice as many and no further."""

    def __init__(self, width: int, most: int) -> None:
        self.count = 0  # rows that came so far
        self.size = 0
        self._most = most
        shape, column = (8, width), (8, 1)
        self._kept = Extremes(
            np.empty(shape), np.empty(shape), _stamps(shape), _stamps(shape), _stamps(column),
            _stamps(column),
        )  # fmt: skip

    def add(self, stamp: int, values: Array) -> None:
        """Take a row as it came."""
        self._make_room(1)
        low, high, *stamps = self._kept
        low[self.size] = high[self.size] = values
        for each in stamps:
            each[self.size] = stamp
        self.size += 1
        self.count += 1

    def extend(self, buckets: Extremes) -> None:
        """Take some rows, fewer than are kept."""
        count = len(buckets.low)
        self._make_room(count)
        for each, new in zip(self._kept, buckets, strict=True):
            each[self.size : self.size + count] = new
        self.size += count
        self.count += count

    def _make_room(self, count: int) -> None:
        """See that so many rows can be written, where need be in place of the oldest."""
        if self.size + count > 2 * self._most:
            for each in self._kept:
                each[: self._most] = each[self.size - self._most : self.size]
            self.size = self._most
        while self.size + count > len(self._kept.low):
            there = len(self._kept.low)
            more = min(there, 2 * self._most - there)
            self._kept = _joined([self._kept, self._kept.part(slice(more))])

    def last(self, count: int) -> Extremes:
        """Return the newest rows."""
        return self._kept.part(slice(self.size - count, self.size))


class Thinned:
    """Rows of `width` numbers by stamp (ns), in the order in which they come.

    The newest are kept as they are; older ones in buckets of 4, 16, 64, ..., of which the least and
    the largest number of each column are known, with their stamps. So no spike is lost, and memory
    has a bound whatever comes.
    """

    def __init__(self, width: int, settings: ThinningSettings = SETTINGS) -> None:
        self.width = width
        self._settings = settings
        self.clear()

    def clear(self) -> None:
        """Forget all rows."""
        self._levels = [_Level(self.width, self._settings.rows)]
        self.newest: int | None = None

    def __len__(self) -> int:
        """Return how many rows came."""
        return self._levels[0].count

    def add(self, stamp: int, row: Iterable[float]) -> None:
        """Take a row of `width` numbers; NaN: not measured, or not known."""
        values = np.fromiter(row, dtype=np.float64, count=self.width)
        self.newest = stamp if self.newest is None else max(self.newest, stamp)
        self._levels[0].add(stamp, values)
        for place, level in enumerate(self._levels):
            if level.count % BLOCK or place + 1 == self._settings.levels:
                break
            if place + 1 == len(self._levels):
                self._levels.append(_Level(self.width, self._settings.rows))
            self._levels[place + 1].extend(level.last(BLOCK).merged(FACTOR))

    @property
    def oldest(self) -> int | None:
        """The stamp (ns) of the oldest row that is kept, alone or in a bucket; None before any."""
        coarsest = self._levels[-1]
        return int(coarsest.last(coarsest.size).begin[0, 0]) if coarsest.size else None

    def goes_back(self, stamp: int) -> bool:
        """Whether a stamp lies so far before the newest one that it is no late sample."""
        raw = self._levels[0].last(self._levels[0].size).begin
        if self.newest is None or len(raw) < 2:
            return self.newest is not None and stamp < self.newest
        step = (self.newest - int(raw.min())) / (len(raw) - 1)
        return self.newest - stamp > self._settings.late * max(step, 1.0)

    def raw(self, begin: int, end: int) -> tuple[IntArray, Array]:
        """Return stamps (K,) and rows (K, w), as they came, of the newest ones in begin to end."""
        level = self._levels[0]
        rows = level.last(level.size)
        stamps = rows.begin[:, 0]
        kept = (stamps >= begin) & (stamps <= end)
        return stamps[kept], rows.low[kept]

    def between(self, begin: int, end: int, most: int) -> Extremes:
        """Return at most `most` buckets that hold all rows stamped `begin` to `end` (ns).

        They are the finest that reach back so far; the first and the last may reach beyond.
        """
        found = self._tiled(begin)
        found = found.part((found.end[:, 0] >= begin) & (found.begin[:, 0] <= end))
        return found.merged(-(-len(found.low) // most)) if len(found.low) > most else found

    def _tiled(self, begin: int) -> Extremes:
        """Return the buckets of the finest level that reaches back to `begin`, or of the coarsest.

        What is not yet in a bucket of it follows, from the finer ones.
        """
        chosen = len(self._levels) - 1
        for place, level in enumerate(self._levels):
            whole = level.size == level.count
            rows = level.last(level.size)
            if whole or rows.begin[0, 0] <= begin:
                chosen = place
                break
        parts = [self._levels[chosen].last(self._levels[chosen].size)]
        parts += [level.last(level.count % BLOCK) for level in self._levels[:chosen][::-1]]
        return _joined(parts)


def _joined(parts: Sequence[Extremes]) -> Extremes:
    """Return buckets that follow one another."""
    return Extremes._make(map(np.concatenate, zip(*parts, strict=True)))


def _stamps(shape: tuple[int, int]) -> IntArray:
    return np.empty(shape, dtype=np.int64)


def _blocks(values: Array, stamps: IntArray, count: int, room: int) -> tuple[Array, IntArray]:
    """Return both as blocks (count, size, w): the last one is filled up with NaN."""
    if room:
        values = np.concatenate([values, np.full((room, values.shape[1]), np.nan)])
    return values.reshape(count, -1, values.shape[1]), _filled(stamps, count, room)


def _filled(stamps: IntArray, count: int, room: int) -> IntArray:
    """Return stamps as blocks (count, size, w): the last one is filled up with its last stamp."""
    whole = np.concatenate([stamps, np.repeat(stamps[-1:], room, axis=0)]) if room else stamps
    return whole.reshape(count, -1, stamps.shape[1])
