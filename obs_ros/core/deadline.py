"""A moment on the steady clock by which an answer is wanted."""

import math
import time


class Deadline:
    """`seconds` from now, or never (None). Raises ValueError when it is negative or NaN."""

    def __init__(self, seconds: float | None = None) -> None:
        if seconds is not None and not seconds >= 0.0:
            raise ValueError(f'deadline {seconds} s is not a number >= 0')
        self._begin = self._now()
        self._end = math.inf if seconds is None else self._begin + seconds

    def later(self, seconds: float) -> 'Deadline':
        """Return one that passes so many seconds later, as if what took them had not been."""
        other = Deadline()
        other._begin, other._end = self._begin + seconds, self._end + seconds
        return other

    @property
    def never(self) -> bool:
        """Whether it never passes."""
        return math.isinf(self._end)

    @property
    def remaining(self) -> float:
        """Seconds left; negative when it has passed."""
        return self._end - self._now()

    @property
    def elapsed(self) -> float:
        """Seconds since it was set."""
        return self._now() - self._begin

    @staticmethod
    def _now() -> float:
        return time.monotonic()

    @property
    def passed(self) -> bool:
        """Whether the time is over."""
        return self.remaining <= 0.0
