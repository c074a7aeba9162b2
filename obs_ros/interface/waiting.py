"""What a node that has nothing to publish says on the terminal, again and again but ever rarer."""

from obs_ros.interface.status import Health

WAITS = ('waiting', 'collecting', 'behind', 'stale_output', 'stale_input', 'mixed')  # outcomes
FIRST = 10  # examinations from one line to the next, then twice as many each time


class Waiting:
    """Picks out of the healths, one a second, those that the terminal should show."""

    def __init__(self) -> None:
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
            self._next = max(FIRST, 2 * self._next)
        self._seen += 1
        return health.message if due else ''
