"""Lines on the terminal of a node that has nothing to publish: again and again, but ever rarer."""

from obs_ros.interface.status import Health

WAITS = ('waiting', 'collecting', 'behind', 'stale_output', 'stale_input', 'mixed')  # outcomes


class Waiting:
    """Picks out of the healths, one a second, those that the terminal should show.

    From the first line to the next there are `first` healths, then twice as many each time.
    """

    def __init__(self, first: int = 10) -> None:
        self._first = first
        self._for: object = None
        self._seen = 0
        self._next = 0

    def line(self, health: Health) -> str:
        """Return what to log of a health, empty where nothing is waited for or it was just said."""
        outcome = health.figures.get('outcome')
        waits = (outcome, health.level) if outcome in WAITS else None
        if waits != self._for:
            self._for, self._seen, self._next = waits, 0, 0
        if waits is None:
            return ''
        due = self._seen == self._next
        if due:
            self._next = max(self._first, 2 * self._next)
        self._seen += 1
        return health.message if due else ''
