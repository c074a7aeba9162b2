"""Who publishes: messages of one topic that come from several publishers, and lost ones."""

from collections import deque
from collections.abc import Callable

CHAINS = 8  # publishers told apart
NEAR = 100  # numbers that one publisher may skip, where there are several
RECENT = 1000  # messages
RETURNS = 3  # among them; a publisher that starts again never returns


class Turns:
    """Follows the numbers that each publisher gives its messages, one more each time.

    A number that follows on that of an earlier message, not of the last one, shows that a publisher
    takes a turn again, be it message by message or burst by burst. Gaps are `lost`
    messages while there is one publisher only; `publishers` counts them. Middleware that gives no
    numbers tells nothing.
    """

    def __init__(self, publishers: Callable[[], int]) -> None:
        self.lost = 0
        self._publishers = publishers
        self._chains: list[int] = []  # the last number of each publisher, the last heard first
        self._count = 0
        self._returns: deque[int] = deque(maxlen=RETURNS)  # at which message

    @property
    def taken(self) -> bool:
        """Whether publishers take turns now."""
        return len(self._returns) == RETURNS and self._count - self._returns[0] < RECENT

    def note(self, number: int | None) -> None:
        """Take the number of the newest message."""
        if not number:
            return
        self._count += 1
        place = self._continued(number)
        if place is not None:
            if place:
                self._returns.append(self._count)
            del self._chains[place]
        self._chains.insert(0, number)
        del self._chains[CHAINS:]

    def _continued(self, number: int) -> int | None:
        """Return the place of the chain that goes on with that number; None where one begins."""
        chains = self._chains
        nearest = max((last for last in chains if last < number), default=None)
        if nearest is None:
            return None
        if number - nearest > 1 and number > chains[0] and self._publishers() <= 1:
            self.lost += number - chains[0] - 1
            return 0
        return chains.index(nearest) if number - nearest <= NEAR else None
