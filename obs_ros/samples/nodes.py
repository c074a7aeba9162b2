"""The nodes of a discrete model, one a period: samples get the stamps of those they belong to."""

import math
from bisect import bisect_right
from collections import deque
from collections.abc import Mapping, MutableMapping, Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from obs_ros.core.typing import Array, IntArray
from obs_ros.samples.delay_line import Receiver
from obs_ros.samples.merge import Role

Offset = TypeVar('Offset', int, IntArray)

COUNTS = {
    'off_grid': "samples between the nodes of a discrete model's period: outputs are dropped, "
    'inputs are in force from the next node on',
}


@dataclass(frozen=True)
class NodeSettings:
    """Limits within which stamps keep to a period.

    - `tolerance`: share of the period from a node to the farthest stamp that belongs to it;
    - `enough`, `remembered`: outputs, at first and at most, whose phase the nodes follow;
    - `moved`: share of the period by which their middle may be off before the nodes follow;
    - `stray`: outputs so many median deviations off, or `least` of the period, tell nothing of it;
    - `half`: of the outputs; where so many are on nodes, these stay but for drift: of two sensors
      that take turns the first one counts;
    - `most`: of the outputs; where so many agree on another phase, it is that of the nodes;
    - `most_phases`: phases that are remembered, for samples that come late.
    """

    tolerance: float = 0.1
    enough: int = 3
    remembered: int = 16
    moved: float = 0.03
    stray: float = 5.0
    least: float = 0.01
    half: float = 0.5
    most: float = 0.75
    most_phases: int = 64


NODES = NodeSettings()


class Phase:
    """The phase of the nodes, which is learned from the outputs and followed.

    The first output is a node. Where outputs agree on another phase, as the first one was late or
    clocks drift, nodes are there from then on: between two phases lies a step that is a little
    longer or shorter.
    """

    def __init__(self, period: float, settings: NodeSettings = NODES) -> None:
        self.period = round(1e9 * period)  # ns
        self.tolerance = math.floor(settings.tolerance * self.period)
        self._settings = settings
        self.clear()

    def clear(self) -> None:
        """Forget the phase."""
        self._since: list[int] = []  # stamps (ns), from which on
        self._anchors: list[int] = []  # these are nodes
        self._off: deque[int] = deque(maxlen=self._settings.remembered)

    def learn(self, stamps: Sequence[int]) -> None:
        """Begin with the phase on which most of the first outputs, of these stamps (ns), agree."""
        if stamps:
            self._anchor(stamps[0], stamps[0])
            self._anchors[0] += self._centre([self.offset(stamp) for stamp in stamps])

    def offset(self, stamp: int) -> int:
        """Return how far (ns) a stamp is from the nearest node; 0 where none is known."""
        if not self._anchors:
            return 0
        return self._wrapped(stamp - self._anchors[max(0, bisect_right(self._since, stamp) - 1)])

    def follow(self, stamp: int) -> int:
        """Take the stamp (ns) of a new output; return how far it is from the nearest node."""
        if not self._anchors:
            self._anchor(stamp, stamp)
        off = self.offset(stamp)
        self._off.append(off)
        if len(self._off) >= self._settings.enough:
            centre = self._centre(self._off)
            if centre:
                self._anchor(stamp, stamp - off + centre)
                moved = [self._wrapped(each - centre) for each in self._off]
                self._off.clear()
                self._off.extend(moved)
                off = moved[-1]
        return off

    def _centre(self, offsets: Sequence[int]) -> int:
        """Return how far (ns) the nodes are to move; 0 where they are right for these outputs.

        They move to the middle of the outputs, strays aside, once one would no longer belong to
        them, or the middle is off: so jitter of a tenth loses none.
        """
        low, high, moved = min(offsets), max(offsets), self._settings.moved * self.period
        if -self.tolerance <= low and high <= self.tolerance and abs(low + high) <= 2.0 * moved:
            return 0
        off = np.array(offsets, dtype=np.int64)
        begin = self._agreed(off)
        if begin is None:
            return 0
        around = self._wrapped(off - begin)
        around = around[np.abs(around) <= self.period // 4]
        middle = np.median(around)
        deviation = self._settings.stray * float(np.median(np.abs(around - middle)))
        reach = max(deviation, self._settings.least * self.period)
        kept = np.sort(around[np.abs(around - middle) <= reach])
        while kept[-1] - kept[0] > 2 * self.tolerance:  # no phase of the nodes suits all
            kept = kept[:-1] if kept[-1] - middle > middle - kept[0] else kept[1:]
        low, high = int(kept[0]), int(kept[-1])
        beyond = low < -self.tolerance or high > self.tolerance
        if begin == 0 and not beyond and abs(low + high) <= 2.0 * moved:
            return 0
        return self._wrapped(begin + (low + high) // 2)

    def _agreed(self, off: IntArray) -> int | None:
        """Return an offset (ns) that enough outputs share: 0, if they do; None where none is."""
        if (np.abs(off) <= self.tolerance).mean() >= self._settings.half:
            return 0
        together = np.abs(self._wrapped(off[None] - off[:, None])) <= self.tolerance
        best = int(together.mean(axis=1).argmax())
        return int(off[best]) if together[best].mean() >= self._settings.most else None

    def _wrapped(self, offset: Offset) -> Offset:
        half = self.period // 2
        return (offset + half) % self.period - half

    def _anchor(self, since: int, node: int) -> None:
        self._since.append(since)
        self._anchors.append(node)
        if len(self._since) > self._settings.most_phases:
            del self._since[0], self._anchors[0]


class NodeLine:
    """Hands outputs on to a `store` at the nodes that they belong to, and inputs so that they act.

    An output within `NodeSettings.tolerance` of a node has that node's stamp from here on; others
    are dropped. An input acts at the first node after its stamp, or at one that is only just
    before. Both kinds are counted. Outputs of one node that come apart are handed on together, at
    the latest when time has gone on.
    """

    def __init__(
        self, store: Receiver, period: float, counts: MutableMapping[str, int],
        settings: NodeSettings = NODES,
    ) -> None:  # fmt: skip
        self.phase = Phase(period, settings)
        self._store = store
        self._counts = counts
        self.clear()

    def clear(self) -> None:
        """Forget the phase, and what waits."""
        self.phase.clear()
        self._held: tuple[int, Array] | None = None
        self._newest: int | None = None  # the newest node whose outputs were handed on

    def forget(self) -> None:
        """See `Store`."""
        self.clear()
        self._store.forget()

    @property
    def passed(self) -> int | None:
        """See `Store`: in the stamps of nodes."""
        return self._store.passed

    def reached(self, times: Mapping[Role, int]) -> dict[Role, int]:
        """Return the times (ns) that streams have reached, given that of their newest samples.

        A stream that has reached a node has reached all that lies halfway to the next.
        """
        tolerance, half, reached = self.phase.tolerance, self.phase.period // 2, dict(times)
        if (time := reached.get('input')) is not None:
            reached['input'] = time + tolerance + half
        if (time := reached.get('output')) is not None:
            before = time - tolerance - 1
            reached['output'] = before if self._newest is None else max(self._newest + half, before)
        return reached

    def keep(self, role: Role, stamp: int, values: Array) -> bool:
        """Take a sample at its own time (ns); False if an input is there already."""
        if self._held is not None and stamp > self._held[0] + self.phase.tolerance:
            self.release()
        if role == 'input':
            self._counts['off_grid'] += abs(self.phase.offset(stamp)) > self.phase.tolerance
            return self._store.keep('input', stamp - self.phase.tolerance, values)
        newest = self._newest is None or stamp > self._newest - self.phase.tolerance
        off = self.phase.follow(stamp) if newest else self.phase.offset(stamp)
        if abs(off) > self.phase.tolerance:
            self._counts['off_grid'] += 1
            return True
        self._sort_in(stamp - off, values)
        return True

    def release(self) -> None:
        """Hand on the outputs that wait."""
        if self._held is not None:
            node, values = self._held
            self._held = None
            self._hand_on(node, values)

    def _sort_in(self, node: int, values: Array) -> None:
        """Put outputs beside those of the same node that wait; hand them on once all are there."""
        if self._held is not None and self._same(node, self._held[0]):
            node, known = self._held
            if not (np.isnan(known) & ~np.isnan(values)).any():
                self._counts['duplicate'] += 1
                return
            values = np.where(np.isnan(known), values, known)
            self._held = None
        elif self._newest is not None and self._same(node, self._newest):
            node = self._newest
        if np.isnan(values).any() and (self._newest is None or node > self._newest):
            self.release()
            self._held = node, values
        else:
            self._hand_on(node, values)

    def _same(self, node: int, other: int) -> bool:
        """Whether two stamps (ns) are those of one node, whose phase may have changed."""
        return 2 * abs(node - other) < self.phase.period

    def _hand_on(self, node: int, values: Array) -> None:
        passed = self._store.passed
        newest = self._newest is None or node > self._newest
        if not newest and passed is not None and node <= passed:
            self._counts['late'] += 1
        elif not self._store.keep('output', node, values):
            self._counts['duplicate'] += 1
        if newest:
            self._newest = node
