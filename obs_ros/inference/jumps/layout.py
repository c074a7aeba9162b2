"""Places of the times and values of jumps in the point of a window."""

from dataclasses import dataclass
from functools import cached_property
from itertools import accumulate
from typing import NamedTuple

import numpy as np

from obs_ros.core.typing import Array, IntArray


class PlacedJump(NamedTuple):
    """Jump of one parameter at an event's time; `before` and `after` are its values' places."""

    event: int
    parameter: int
    before: int
    after: int


@dataclass(frozen=True)
class Layout:
    """Places of times and values in a point (D,) of a window with jumps.

    A point is z (d,), the unknowns at the window's start; then for each event its time, a share of
    the window, and the values of its parameters from then on, in boxes. `events` holds for each
    event the places of its parameters in z.
    """

    dimension: int
    events: tuple[tuple[int, ...], ...] = ()

    @property
    def size(self) -> int:
        """Number of values, D."""
        return self.dimension + sum(1 + len(event) for event in self.events)

    @cached_property
    def times(self) -> IntArray:
        """Places (E,) of the events' times."""
        places = accumulate((1 + len(event) for event in self.events), initial=self.dimension)
        return np.array(list(places)[:-1], dtype=np.int64)

    def jumped(self, point: Array) -> list[PlacedJump]:
        """Return the jumps of single parameters at a point (D,), in order of time."""
        if not self.events:
            return []
        latest: dict[int, int] = {}
        found = []
        times = self.times
        for event in np.argsort(point[times], kind='stable'):
            for i, parameter in enumerate(self.events[event]):
                after = int(times[event]) + 1 + i
                before = latest.get(parameter, parameter)
                found.append(PlacedJump(int(event), parameter, before, after))
                latest[parameter] = after
        return found

    def final(self, point: Array) -> IntArray:
        """Return the places (d,) of the values that hold at the end of the window."""
        places = np.arange(self.dimension)
        if not self.events:
            return places
        for jump in self.jumped(point):
            places[jump.parameter] = jump.after
        return places
