"""Plant time on the wall clock, so that a live run neither drifts nor bursts."""

import time
from collections.abc import Callable


class PlantClock:
    """Plant time that runs `speed` times as fast as the wall time of `clock` (s).

    Samples that come late are caught up with. A run that lags by more than `catch_up` (wall s) has
    its schedule moved: it is slower than asked for, and `lag` sums up by how much (wall s).
    """

    def __init__(
        self,
        speed: float,
        clock: Callable[[], float] = time.monotonic,
        catch_up: float = 0.5,  # a hiccup is shorter; a longer burst would flood the estimator
    ) -> None:
        self.lag = 0.0
        self._speed = speed
        self._clock = clock
        self._catch_up = catch_up
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
        if late > self._catch_up:
            self.lag += late
            self._start += late
