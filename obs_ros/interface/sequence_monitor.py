"""Publishers of one topic, told apart by the numbers of their messages, and messages lost."""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass


@dataclass(frozen=True)
class SequenceSettings:
    """Limits by which publishers of one topic are told apart."""

    publishers: int = 8  # told apart: more of them on one topic alternate all the same
    most_skipped: int = 100  # numbers that one may skip where there are several: lost in a burst
    returns: int = 3  # to an earlier publisher, to alternate; one that starts again never returns
    recent: int = 1000  # messages within which these count: some seconds, however fast they come


SETTINGS = SequenceSettings()


class SequenceMonitor:
    """Follows the numbers that each publisher gives its messages, one more each time.

    A number that follows on that of an earlier message, not of the last one, is a return: another
    publisher has sent in between, one message or a burst. Gaps are `lost` messages while there is
    one publisher only; `publishers` counts them. Middleware that gives no numbers shows nothing.
    """

    def __init__(
        self, publishers: Callable[[], int], settings: SequenceSettings = SETTINGS
    ) -> None:
        self.lost = 0
        self._publishers = publishers
        self._settings = settings
        self._chains: list[int] = []  # the last number of each publisher, the last heard first
        self._count = 0
        self._returns: deque[int] = deque(maxlen=self._settings.returns)  # at which message

    @property
    def alternating(self) -> bool:
        """Whether several publishers send by turns now."""
        settings = self._settings
        enough = len(self._returns) == settings.returns
        return enough and self._count - self._returns[0] < settings.recent

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
        del self._chains[self._settings.publishers :]

    def _continued(self, number: int) -> int | None:
        """Return the place of the chain that goes on with that number; None where one begins."""
        chains = self._chains
        nearest = max((last for last in chains if last < number), default=None)
        if nearest is None:
            return None
        if number - nearest > 1 and number > chains[0] and self._publishers() <= 1:
            self.lost += number - chains[0] - 1
            return 0
        return chains.index(nearest) if number - nearest <= self._settings.most_skipped else None
