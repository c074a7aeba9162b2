"""Announcements of jumps: which are news, and which announced ones are taken back.

A jump is one event, whatever it is called: windows that overlap show it again and again, by this
set of parameters or by a larger one. It is announced once, when a window explains it clearly and
jumps are rare; it is taken back when later evidence turns clearly to another set, or to none.
Where the model lacks something, a jump in nearly every window stands for it: that is a drift.
"""

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import NamedTuple

import numpy as np

from obs_ros.core.changes import replace
from obs_ros.core.drifting import remedy
from obs_ros.core.estimate import Estimate, Jump
from obs_ros.horizon.arrival_cost import KEPT
from obs_ros.horizon.beliefs import Beliefs, jump_among
from obs_ros.horizon.found_jumps import JumpFound
from obs_ros.horizon.gaussian_sum import SUM, same_event, set_at


@dataclass(frozen=True)
class AnnouncementSettings:
    """Limits of clear jumps, of doubt about them, and of rare ones.

    - `clear`: standard deviations of a size, from none: 95 % two-sided;
    - `doubt`: probability of no jump at all, from which on none is announced; `doubt_pushed` the
      same beside process noise, whose innovations leave far more false ones: on plants that the
      model lacks something of, the evidence for these was below 35, for true ones above 70;
    - `odds`, `majority`: of another set against the one announced, and its probability, from which
      on the evidence has turned: below, noise of one window turns it back again;
    - `inside`: share of a window that must lie before a jump for the window to decide on it;
    - `rare`: share of the windows of late that may have jumped; more are a drift, unless they are
      no more than the `fewest`: two faults in a row are none;
    - `exact`: share of the windows of late that noise alone, or a jump, explains, below which a
      jump must be as clear as beside process noise;
    - `lately`: windows that are counted.
    """

    clear: float = 2.0
    doubt: float = 0.05
    odds: float = 3.0
    majority: float = 0.5
    inside: float = 0.125
    doubt_pushed: float = 2e-9
    rare: float = 1.0 / 3.0
    fewest: int = 2
    exact: float = 2.0 / 3.0
    lately: int = 9


class Kind(StrEnum):
    """What a window is explained by: noise alone, parameters that moved, or neither."""

    CALM = 'calm'
    MOVED = 'moved'
    ROUGH = 'rough'


class _Window(NamedTuple):
    """A window from `start` to `end` (s), and the parameters that moved in it.

    Of the `undated` ones nothing says when.
    """

    start: float
    end: float
    kind: Kind
    moved: frozenset[str]
    undated: frozenset[str] = frozenset()


@dataclass
class _Event:
    """A jump that windows showed, as it was shown last, or as it was announced.

    `credible`: some window that decides shows it. It is not announced later where it was not, nor
    if it is `barred`, as it came when jumps were not rare.
    """

    found: JumpFound
    jump: Jump
    credible: bool = False
    announced: bool = False
    barred: bool = False


@dataclass(frozen=True)
class AnnouncementMemory:
    """The jumps and windows of late, and the walks of what drifts; see `Announcements`."""

    events: tuple[_Event, ...]
    windows: tuple[_Window, ...]
    rates: Mapping[str, float]


class Announcements:
    """The jumps of the latest windows, announced or not yet."""

    def __init__(self, settings: AnnouncementSettings = AnnouncementSettings()) -> None:
        self.settings = settings
        self._events: list[_Event] = []
        self._windows: list[_Window] = []
        # Variances per s of the walks of parameters that drift, in boxes, by name.
        self.rates: dict[str, float] = {}

    @property
    def memory(self) -> AnnouncementMemory:
        """All that is known; nothing changes it later."""
        events = tuple(replace(event) for event in self._events)
        return AnnouncementMemory(events, tuple(self._windows), dict(self.rates))

    def recall(self, memory: AnnouncementMemory) -> None:
        """Know what another one knew."""
        self._events = [replace(event) for event in memory.events]
        self._windows, self.rates = list(memory.windows), dict(memory.rates)

    def announced(
        self,
        estimate: Estimate,
        beliefs: Beliefs,
        *,
        explained: bool,
        alone: bool,
        moving: Iterable[str] = (),
    ) -> Estimate:
        """Return the estimate with its news marked, and with those of earlier jumps.

        Only a window that is `explained`, and whose deviations are given, decides anything.
        `alone`: by the model and noise alone, but for jumps; `moving` names parameters that are not
        constant in it.
        """
        # Longer than lineages remember: none may bring an old jump back.
        oldest = estimate.t1 - (max(SUM.remembered, self.settings.lately) + 2) * beliefs.duration
        self._events = [event for event in self._events if event.found.time > oldest]
        self._windows = [window for window in self._windows if window.start > oldest][-KEPT:]
        decides = explained and not np.isnan(list(estimate.stddev.values())).all()
        undated = frozenset(moving)
        moved = undated | self._noted(estimate, beliefs, decides=decides)
        kind = Kind.MOVED if moved else Kind.CALM if alone else Kind.ROUGH
        self._windows.append(_Window(estimate.t0, estimate.t1, kind, moved, undated))
        # Without any other window nobody knows whether jumps are rare.
        begun = any(known.kind is not Kind.MOVED for known in self._windows)
        lately = self._lately()
        kinds = [window.kind for window in lately]
        often = kinds.count(Kind.MOVED) > max(
            self.settings.fewest, self.settings.rare * len(lately)
        )
        drifting = self._drifting(lately, beliefs.duration) if often else ()
        self.rates = self.rates if often else {}
        estimate = replace(estimate, drifting=tuple(dict.fromkeys((*estimate.drifting, *drifting))))
        if often:
            estimate = replace(estimate, message=f'{estimate.message}; {remedy(drifting)}')
        if not decides:
            return estimate
        news = [*self._taken_back(estimate, beliefs, alone=alone)]
        if begun and not often:
            rough = kinds.count(Kind.ROUGH) > (1.0 - self.settings.exact) * len(kinds)
            news += self._announced_now(beliefs, pushed=rough or not alone)
        shown = [
            next((new for new in news if not new.retracted and _same(new, jump)), jump)
            for jump in estimate.jumps
        ]
        late = [new for new in news if not any(new is jump for jump in shown)]
        return replace(
            estimate,
            jumps=(*shown, *late),
            message='; '.join([estimate.message, *map(str, late)]),
        )

    def _lately(self) -> list[_Window]:
        """Return the latest windows that share no sample, the newest first."""
        found: list[_Window] = []
        for window in reversed(self._windows):
            if not found or window.end <= found[-1].start:
                found.append(window)
            if len(found) == self.settings.lately:
                break
        return found

    def _noted(self, estimate: Estimate, beliefs: Beliefs, *, decides: bool) -> frozenset[str]:
        """Note the clear jumps of the most probable lineage; return what the window shows jump.

        Those before the window were no best hypothesis there, or there was doubt; newer windows
        know them better.
        """
        shown = {jump.time: jump for jump in estimate.jumps}
        moved: frozenset[str] = frozenset()
        first = beliefs.every[0]
        for found in first.jumps:
            if not found.clear(self.settings.clear):
                continue
            chances = beliefs.chances(found)
            believed = chances.get(frozenset(), 0.0) < self.settings.doubt
            own = found in first.own
            if believed and own:
                moved |= found.names - self._counted_before(found, beliefs)
            jump = shown.get(found.time)
            event = self._event_at(found, beliefs.duration)
            if event is None:
                jump = jump or jump_among(found, chances, estimate.t1, estimate.stamp)
                event = _Event(found, jump, credible=believed and decides)
                self._events.append(event)
            elif jump is not None and not event.announced:
                event.found, event.jump = found, jump
            event.credible |= believed and decides and own
        return moved

    def _counted_before(self, found: JumpFound, beliefs: Beliefs) -> frozenset[str]:
        """Return what moved at some time in a window that ends where this one shows a jump begin.

        A window that has begun after a jump takes it for its own start: both show one event.
        """
        early = self.settings.inside * beliefs.duration
        if found.time > beliefs.start + early:
            return frozenset()
        near = (w for w in self._windows if w.start <= found.time <= w.end + early)
        return frozenset().union(*(window.undated for window in near))

    def _event_at(self, found: JumpFound, duration: float) -> _Event | None:
        same = [event for event in self._events if same_event(event.found, found, duration)]
        return min(same, key=lambda event: abs(event.found.time - found.time), default=None)

    def _taken_back(self, estimate: Estimate, beliefs: Beliefs, *, alone: bool) -> Iterator[Jump]:
        """Yield retractions of jumps against which the evidence has turned.

        Where it has turned to other parameters, their jump is what remains to be announced.
        """
        for event in list(self._events):
            chances = self._chances(event, beliefs, alone=alone)
            rivals = {names: p for names, p in chances.items() if names != event.found.names}
            if not rivals:
                continue
            names = max(rivals, key=rivals.__getitem__)
            own = chances.get(event.found.names, 0.0)
            if rivals[names] < max(self.settings.majority, self.settings.odds * own):
                continue
            self._events.remove(event)
            if event.announced:
                yield event.jump.taken_back(own)
            if (found := beliefs.shown(event.found, names)) is not None:
                jump = jump_among(found, chances, estimate.t1, estimate.stamp)
                self._events.append(_Event(found, jump, credible=event.credible))

    def _announced_now(self, beliefs: Beliefs, *, pushed: bool) -> Iterator[Jump]:
        """Yield the jumps that are announced by this window, as the newest one has them."""
        for event in self._events:
            if event.announced or event.barred or not event.credible:
                continue
            chances = self._chances(event, beliefs, alone=not pushed)
            sure = not pushed or (
                _shows(beliefs, event.found) and beliefs.still < self.settings.doubt_pushed
            )
            if chances and sure and chances.get(frozenset(), 0.0) < self.settings.doubt:
                probability = chances.get(event.found.names, 0.0)
                event.jump = replace(event.jump, new=True, probability=probability)
                event.announced = True
                yield event.jump

    def _chances(
        self, event: _Event, beliefs: Beliefs, *, alone: bool
    ) -> dict[frozenset[str], float]:
        """Return the probability of each set to have jumped then; empty if the window cannot tell.

        A window that begins just before a jump, and does not find it, takes it for its own start;
        one that noise `alone` does not explain may take it for a push.
        """
        inside = event.found.time >= beliefs.start + self.settings.inside * beliefs.duration
        before = event.found.time <= beliefs.start and any(
            set_at(one.jumps, event.found, beliefs.duration) for one in beliefs.every
        )
        if _shows(beliefs, event.found) or (inside and alone) or before:
            return beliefs.chances(event.found)
        return {}

    def _drifting(self, lately: Sequence[_Window], duration: float) -> tuple[str, ...]:
        """Return the parameters that move too often, and note how far they walk by their jumps."""
        self.rates = {}
        for event in self._events:
            event.barred = not event.announced
            for name, size in event.found.sizes.items():
                walked = size.change**2 / (len(lately) * duration)
                self.rates[name] = self.rates.get(name, 0.0) + walked
        counts = Counter(name for window in lately for name in window.moved)
        most = max(counts.values())
        return tuple(sorted(name for name, count in counts.items() if 2 * count > most))


def _shows(beliefs: Beliefs, event: JumpFound) -> bool:
    """Whether the best hypothesis on a window shows the jump inside it."""
    return bool(set_at(beliefs.every[0].own, event, beliefs.duration))


def _same(one: Jump, other: Jump) -> bool:
    return one.time == other.time and set(one.sizes) == set(other.sizes)
