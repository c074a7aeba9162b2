"""The messages of all topics in order of stamp; those that belong together are one sample."""

import math
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from obs_ros.core.record import Sample
from obs_ros.core.typing import Array

Role = Literal['input', 'output']


@dataclass(frozen=True)
class MergeSettings:
    """The patience of outputs with inputs of their own time."""

    recent: int = 8  # intervals of a topic, by which its next message is due
    longest_due: float = 1.0  # s that outputs wait at most for inputs that are due: they may pause


DEFAULT = MergeSettings()


class Message(NamedTuple):
    """Values (width,), NaN where not measured, at `stamp` (ns); they arrived at `arrival` (s)."""

    stamp: int
    values: Array
    arrival: float


class Topic:
    """One topic that brings entries of the inputs or of the outputs.

    Messages that bring different entries, as those of joints that report alternately, wait in
    queues of their own. With `whole`, each brings all entries of the topic: NaN is measured NaN.
    """

    def __init__(self, role: Role, entries: Sequence[int], recent: int, *, whole: bool) -> None:
        self.role = role
        self.entries = list(entries)
        self.queues: dict[tuple[int, ...], deque[Message]] = {}
        self._whole = whole
        self.newest: int | None = None  # stamp of the newest message; None where it is of no use
        self._intervals: deque[int] = deque(maxlen=recent)
        self.missed = False  # waited for in vain, and not heard since

    def __len__(self) -> int:
        return sum(map(len, self.queues.values()))

    def clear(self) -> None:
        """Forget everything."""
        self.queues.clear()
        self._intervals.clear()
        self.newest, self.missed = None, False

    def add(self, message: Message) -> Sequence[int]:
        """Append a message; return the entries that it brings."""
        stamp, values, _ = message
        if self.newest is not None and stamp > self.newest:
            self._intervals.append(stamp - self.newest)
        self.newest, self.missed = stamp, False
        brought = self.entries
        if not self._whole:
            brought = [i for i in brought if not math.isnan(values[i])]
        self.queues.setdefault(tuple(brought), deque()).append(message)
        return brought

    def goes_back(self, stamp: int) -> bool:
        """Whether a message of that stamp (ns) would be older than the one before."""
        return self.newest is not None and stamp < self.newest

    def due(self, stamp: int) -> bool:
        """Whether its next message, at its usual pace, would have a stamp (ns) up to that one."""
        if not self._intervals:
            return False  # no pace is known
        return self.newest is None or self.newest + min(self._intervals) <= stamp


class Merge:
    """Hands samples to `take(sample, arrival)` in order of stamp, however their topics interleave.

    Messages of one kind stay in the order of their arrival; of all that come next, the one with the
    oldest stamp goes first, inputs before outputs. Messages of one role and one stamp become one
    sample where each entry is measured by one of them only. A message waits while an older one may
    still come, but for `wait` s after its arrival at most:

    - until each entry of its role, inputs or outputs, is known up to its stamp;
    - an output, for `MergeSettings.longest_due` at most, for each topic of inputs that is due by
      its pace so far. One that was waited for in vain is not waited for again until it is heard:
      inputs may pause.

    Times of arrival (s) are of any one clock, such as that of a recording.
    """

    def __init__(
        self,
        wait: float,
        take: Callable[[Sample, float], None],
        settings: MergeSettings = DEFAULT,
    ) -> None:
        self._wait = wait
        self._settings = settings
        self._take = take
        self._topics: list[Topic] = []
        # Stamps of the newest messages, by role and entry.
        self._reached: dict[Role, dict[int, float]] = {'input': {}, 'output': {}}

    def __len__(self) -> int:
        return sum(map(len, self._topics))

    def topic(self, role: Role, entries: Sequence[int], *, whole: bool) -> Topic:
        """Return a new topic that brings these entries; see `Topic`."""
        self._topics.append(Topic(role, entries, self._settings.recent, whole=whole))
        self._reached[role] |= dict.fromkeys(entries, -math.inf)
        return self._topics[-1]

    def add(self, topic: Topic, stamp: int, values: Array, arrival: float) -> None:
        """Take a message of a topic."""
        if topic.goes_back(stamp):
            # Time may begin anew: where the others stood before says nothing of where they are.
            for other in self._topics:
                other.newest = None
            for reached in self._reached.values():
                reached.update(dict.fromkeys(reached, -math.inf))
        brought = topic.add(Message(stamp, values, arrival))
        self._reached[topic.role].update(dict.fromkeys(brought, stamp))

    def release(self, now: float, enough: Callable[[], bool] = lambda: False) -> bool:
        """Hand out messages that need not wait at `now` (s); False if `enough` ended that early."""
        while (head := self._head()) is not None:
            role, queue = head
            stamp, _, arrival = queue[0]
            late = self._due(stamp) if role == 'output' else []
            age = now - arrival
            if (late and age < min(self._wait, self._settings.longest_due)) or (
                age < self._wait and not self._known(role, stamp)
            ):
                break
            if enough():
                return False
            for topic in late:
                topic.missed = True
            self._hand_out(role, queue)
        return True

    def clear(self) -> None:
        """Forget everything."""
        for topic in self._topics:
            topic.clear()
        for reached in self._reached.values():
            reached.update(dict.fromkeys(reached, -math.inf))

    def _head(self) -> tuple[Role, deque[Message]] | None:
        """Return role and queue of the message that is the oldest of those that come next."""
        head: tuple[Role, deque[Message]] | None = None
        for topic in self._topics:  # inputs first, at equal stamps
            for queue in topic.queues.values():
                if queue and (head is None or self._before(topic.role, queue, head)):
                    head = topic.role, queue
        return head

    def _before(self, role: Role, queue: deque[Message], head: tuple[Role, deque[Message]]) -> bool:
        stamp, other = queue[0].stamp, head[1][0].stamp
        return stamp < other or (stamp == other and role == 'input' and head[0] == 'output')

    def _known(self, role: Role, stamp: int) -> bool:
        """Whether no message with an older stamp is missing of any entry of that role.

        Every message that waits has that stamp or a newer one.
        """
        reached = self._reached[role]
        if min(reached.values()) >= stamp:
            return True
        waiting = {
            entry
            for topic in self._topics
            for entries, queue in topic.queues.items()
            if topic.role == role and queue
            for entry in entries
        }
        return all(time >= stamp or entry in waiting for entry, time in reached.items())

    def _due(self, stamp: int) -> list[Topic]:
        """Return the topics of inputs that an output of that stamp has to wait for."""
        return [
            topic
            for topic in self._topics
            if topic.role == 'input' and not topic.missed and not len(topic) and topic.due(stamp)
        ]

    def _hand_out(self, role: Role, queue: deque[Message]) -> None:
        stamp, values, arrival = queue.popleft()
        for topic in self._topics:
            for other in topic.queues.values() if topic.role == role else ():
                if (
                    other is not queue
                    and other
                    and other[0].stamp == stamp
                    and not _both(values, other[0].values)
                ):
                    more = other.popleft()
                    values = np.where(np.isnan(values), more.values, values)
                    arrival = max(arrival, more.arrival)
        sample = Sample(stamp, u=values) if role == 'input' else Sample(stamp, y=values)
        self._take(sample, arrival)


def _both(one: Array, other: Array) -> bool:
    """Whether any entry is measured in both."""
    return bool((~np.isnan(one) & ~np.isnan(other)).any())
