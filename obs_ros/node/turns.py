"""Who publishes: messages of one stream that come from several publishers, and lost ones."""

from collections import deque

RECENT = 20  # messages
SWITCHES = 3  # among them; a publisher that starts again is one


class Turns:
    """Follows the numbers that a publisher gives its messages, one more each time.

    Where several publishers take turns, numbers go back again and again. Gaps are `lost` messages,
    as long as only one publishes. Middleware that gives no numbers tells nothing.
    """

    def __init__(self) -> None:
        self.lost = 0
        self._last: int | None = None
        self._switches: deque[bool] = deque(maxlen=RECENT)

    @property
    def taken(self) -> bool:
        """Whether publishers take turns now."""
        return sum(self._switches) >= SWITCHES

    def note(self, number: int | None) -> None:
        """Take the number of the newest message."""
        if not number:
            return
        if self._last is not None:
            self._switches.append(number <= self._last)
            if not any(self._switches):
                self.lost += number - self._last - 1
        self._last = number
