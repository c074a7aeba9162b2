"""A moment by which an answer is wanted; the clock stands still while code compiles."""

import contextlib
import math
import threading
import time
from collections.abc import Iterator


class _Left(threading.local):
    """Seconds that the clock of this thread left out, and how many blocks do so now."""

    seconds = 0.0
    depth = 0


_left = _Left()


class Deadline:
    """`seconds` from now, or never (None). Raises ValueError when it is negative or NaN.

    It is for the thread that makes it, whose time in `uncounted` blocks does not count.
    """

    def __init__(self, seconds: float | None = None) -> None:
        if seconds is not None and not seconds >= 0.0:
            raise ValueError(f'deadline {seconds} s is not a number >= 0')
        self._begin = self._clock()
        self._end = math.inf if seconds is None else self._begin + seconds

    @property
    def never(self) -> bool:
        """Whether it never passes."""
        return math.isinf(self._end)

    @property
    def remaining(self) -> float:
        """Seconds left; negative when it has passed."""
        return self._end - self._clock()

    @property
    def elapsed(self) -> float:
        """Seconds since it was set."""
        return self._clock() - self._begin

    @classmethod
    def _clock(cls) -> float:
        return cls._now() - _left.seconds

    @staticmethod
    def _now() -> float:
        return time.monotonic()

    @property
    def passed(self) -> bool:
        """Whether the time is over."""
        return self.remaining <= 0.0


@contextlib.contextmanager
def uncounted() -> Iterator[None]:
    """Let the time of a block, which is spent once and never again, count in no deadline."""
    begin = Deadline._now() if _left.depth == 0 else 0.0
    _left.depth += 1
    try:
        yield
    finally:
        _left.depth -= 1
        if _left.depth == 0:
            _left.seconds += Deadline._now() - begin
