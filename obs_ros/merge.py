"""Samples of one stream that come by several topics: in order of stamp, same stamps in one."""

from bisect import bisect_left, bisect_right
from collections import deque
from collections.abc import Callable

import numpy as np

from obs_ros.typing import Array


class Merge:
    """Hands partial samples (width,), NaN where an entry is not measured, to `take(stamp, values)`.

    A sample waits until every entry is known up to its stamp (ns), but no longer than `wait` s of
    the clock that `now` is read from: so a topic that is slow or silent holds up nobody for longer.
    Later than that, it comes out as it comes in. Samples of one stamp become one where each entry
    is measured by one of them only.
    """

    def __init__(self, width: int, wait: float, take: Callable[[int, Array], None]) -> None:
        self._wait = wait
        self._take = take
        # The newest message counts, not the newest stamp: time may begin anew.
        self._reached: Array = np.full(width, -np.inf)
        self._stamps: list[int] = []  # of what is held, in order
        self._values: list[Array] = []
        self._arrivals: deque[tuple[float, int]] = deque()

    def __len__(self) -> int:
        return len(self._stamps)

    def add(self, stamp: int, values: Array, now: float) -> None:
        """Take a sample that arrived at `now` (s), and hand out what need not wait any more."""
        known = ~np.isnan(values)
        self._reached[known] = stamp
        first, last = bisect_left(self._stamps, stamp), bisect_right(self._stamps, stamp)
        for k in range(first, last):
            if not (known & ~np.isnan(self._values[k])).any():
                self._values[k] = np.where(known, values, self._values[k])
                break
        else:
            self._stamps.insert(last, stamp)
            self._values.insert(last, values)
            self._arrivals.append((now, stamp))
        self.release(now)

    def release(self, now: float) -> None:
        """Hand out what is complete at `now` (s), or has waited for long enough."""
        until: float = self._reached.min()
        while self._arrivals and now - self._arrivals[0][0] >= self._wait:
            until = max(until, self._arrivals.popleft()[1])
        count = bisect_right(self._stamps, until)
        if not count:
            return
        due = list(zip(self._stamps[:count], self._values[:count], strict=True))
        del self._stamps[:count], self._values[:count]
        if not self._stamps:
            self._arrivals.clear()
        for stamp, values in due:
            self._take(stamp, values)

    def clear(self) -> None:
        """Forget everything."""
        self._reached[:] = -np.inf
        self._stamps.clear()
        self._values.clear()
        self._arrivals.clear()
