"""When samples are due on the wall clock, so that a live run neither drifts nor bursts."""

import time
from collections.abc import Callable

CATCH_UP = 0.5  # s of wall time that a run may lag before its schedule is moved


class Pace:
    """An absolute schedule on the steady clock: plant time runs `speed` times as fast as wall time.

    Samples that come late are caught up with. A run that lags by more than CATCH_UP has its
    schedule moved: it is slower than asked for, and `lag` sums up by how much (wall s). `clock`
    tells the wall time, in s.
    """

    def __init__(self, speed: float, clock: Callable[[], float] = time.monotonic) -> None:
        self.lag = 0.0
        self._speed = speed
        self._clock = clock
        self._start = clock()

    def now(self) -> float:
        """Return the plant time that has come, in s."""
        return (self._clock() - self._start) * self._speed

    def change(self, speed: float, t: float) -> None:
        """Go on from plant time `t` at another speed."""
        self._speed = speed
        self._start = self._clock() - t / speed

    def hold(self, t: float) -> None:
        """Make plant time be `t` now, as after a pause."""
        self.change(self._speed, t)

    def yield_to(self, t: float) -> None:
        """Move the schedule when the next sample, due at plant time `t`, is late beyond hope."""
        late = self._clock() - (self._start + t / self._speed)
        if late > CATCH_UP:
            self.lag += late
            self._start += late
