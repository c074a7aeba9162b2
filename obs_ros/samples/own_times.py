"""From the stamps of messages to the times at which samples are kept: delays, then nodes."""

from collections.abc import Mapping, MutableMapping

from obs_ros.samples.delay_line import DelayLine, Receiver, Shifts
from obs_ros.samples.merge import Role
from obs_ros.samples.nodes import NodeLine


class OwnTimes:
    """What lies before a `store`: a `DelayLine` where signals have delays, a `NodeLine` for nodes.

    `period` (s) is that of a discrete model, else None. What does not fit is counted by reason in
    `counts`. Samples go to `entrance`, which is the very store where nothing lies before it.
    """

    def __init__(
        self, store: Receiver, shifts: Shifts | None, period: float | None,
        counts: MutableMapping[str, int],
    ) -> None:  # fmt: skip
        self._nodes = None if period is None else NodeLine(store, period, counts)
        behind: Receiver = self._nodes or store
        self._line = None if shifts is None else DelayLine(behind, shifts)
        self.entrance: Receiver = self._line or behind

    def shift(self, shifts: Shifts | None) -> None:
        """Let samples be shifted by other times from now on, if there are delays at all."""
        if self._line is not None and shifts is not None:
            self._line.shift(shifts)

    def clear(self) -> None:
        """Forget the samples that wait, and the phase of the nodes."""
        for line in (self._line, self._nodes):
            if line is not None:
                line.clear()

    def earliest(self, role: Role) -> int:
        """Return the least shift (ns) of a role that has signals."""
        return 0 if self._line is None else self._line.earliest(role)

    def reached(self, newest: Mapping[Role, int]) -> int:
        """Return the time (ns) that streams of these newest stamps (ns) have reached."""
        times = {role: stamp + self.earliest(role) for role, stamp in newest.items()}
        return min((times if self._nodes is None else self._nodes.reached(times)).values())
