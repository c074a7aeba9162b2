"""Lines on the terminal of a node: what it waits for, and parameters that begin to drift."""

from collections.abc import Iterator

from obs_ros.interface.status import Health, Level
from obs_ros.interface.waiting import Waiting


class Terminal:
    """Picks out of the healths, one a second, what the terminal should show, with its level.

    A drift is said once, until other parameters drift.
    """

    def __init__(self) -> None:
        self._waiting = Waiting()
        self._drifting: object = None

    def lines(self, health: Health) -> Iterator[tuple[Level, str]]:
        """Yield what to log of a health."""
        if line := self._waiting.line(health):
            yield health.level, line
        drifting = health.figures.get('drifting', self._drifting)
        if drifting != self._drifting:
            self._drifting = drifting
            yield Level.WARN, str(drifting)
