"""All estimators that are heard, shared by whoever listens and whoever serves pages."""

import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from threading import Lock
from typing import Any

from obs_ros.core.texts import LONGEST_LINE, one_line
from obs_ros.interface.vectors import Vector
from obs_ros.pages.information import Information
from obs_ros.pages.observed import PLAIN, Observed
from obs_ros.pages.payload import Seen, Told, answer

PLANT = frozenset(PLAIN)  # topics of the plant, not of the estimator


@dataclass
class Presence:
    """How an estimator is heard; times in s of the steady clock."""

    observed: Observed
    present: bool = True  # whether somebody publishes its topics
    since: float = 0.0  # when `present` was what it is
    heard: float | None = None  # the last message of its own
    lost: int = 0  # messages of its topics, and its plant's, on their way here
    plant: str = ''  # the topics that it hears
    level: int = 0  # of its health, as in DiagnosticStatus
    health: str = ''


@dataclass(frozen=True)
class BoardSettings:
    """Limits of what is kept and told."""

    most: int = 16  # estimators: each takes some MB when it has run for long
    silent: float = 5.0  # s without a word after which an estimator is called silent
    most_points: int = 2000  # buckets of a curve in one answer
    most_shown: int = 6  # estimators in one answer: there are as many colours


SETTINGS = BoardSettings()


class Board:
    """Estimators by name. All methods may be called from any thread."""

    def __init__(self, settings: BoardSettings = SETTINGS) -> None:
        self._settings = settings
        self._lock = Lock()
        self._all: dict[str, Presence] = {}
        self.origin: int | None = None  # ns: times of answers count from here
        self.notes: Sequence[str] = ()  # what the reader of the page should know beside

    @property
    def names(self) -> list[str]:
        """The estimators' names, sorted."""
        with self._lock:
            return sorted(self._all)

    def inform(self, name: str, info: Information) -> None:
        """Take what an estimator says of itself; one with other variables begins anew."""
        with self._lock:
            known = self._all.get(name)
            if known is None or known.observed.info != info:
                self._all[name] = Presence(Observed(name, info), since=time.monotonic())

    def hear(self, name: str, vector: Vector) -> None:
        """Take a vector for an estimator that is known."""
        with self._lock:
            if (known := self._all.get(name)) is not None:
                if self.origin is None:
                    self.origin = vector.stamp
                known.observed.hear(vector)
                if vector.topic not in PLANT:
                    known.heard = time.monotonic()

    def conclude(self, name: str, stamp: int, outcome: str, message: str) -> None:
        """Take the outcome of an estimate of an estimator that is known."""
        with self._lock:
            if (known := self._all.get(name)) is not None:
                known.observed.conclude(stamp, outcome, message)
                known.heard = time.monotonic()

    def judge(self, name: str, level: int, message: str) -> None:
        """Take the health of an estimator that is known."""
        with self._lock:
            if (known := self._all.get(name)) is not None:
                known.level, known.health = level, one_line(message, LONGEST_LINE)

    def miss(self, name: str, count: int) -> None:
        """Note messages that were lost on their way, for an estimator that is known."""
        with self._lock:
            if (known := self._all.get(name)) is not None:
                known.lost += count

    def follow(self, name: str, plant: str) -> None:
        """Note by which topics an estimator that is known hears its plant."""
        with self._lock:
            if (known := self._all.get(name)) is not None:
                known.plant = plant

    def attend(self, name: str, *, present: bool) -> None:
        """Note whether somebody publishes the topics of an estimator that is known."""
        with self._lock:
            known = self._all.get(name)
            if known is not None and known.present != present:
                known.present, known.since = present, time.monotonic()
                if not present:
                    known.level, known.health = 0, ''

    def forget(self, name: str) -> None:
        """Forget an estimator, if it is known."""
        with self._lock:
            self._all.pop(name, None)

    def answer(self, query: Mapping[str, Sequence[str]]) -> dict[str, Any]:
        """Return what a page asks for.

        `of` are names (default: the first), `points` buckets of a curve; either `from` and `to`
        (s since the origin) or `span` (s up to the newest; default: all that is kept).
        Raises ValueError for a query that no page sends.
        """
        with self._lock:
            asked = list(query.get('of', ())) or sorted(self._all)[:1]
            shown = [self._all[name].observed for name in asked if name in self._all]
            shown = shown[: self._settings.most_shown]
            told = {
                name: Told(*self._words(known), known.lost, known.plant)
                for name, known in sorted(self._all.items())
            }
            return answer(told, shown, self._seen(query, shown), self.notes)

    def _seen(self, query: Mapping[str, Sequence[str]], shown: Sequence[Observed]) -> Seen:
        origin = self.origin or 0
        newest = max((e.newest for e in shown if e.newest is not None), default=origin)
        oldest = min((e.oldest for e in shown if e.oldest is not None), default=origin)
        most = round(min(max(_number(query, 'points', 500.0), 10.0), self._settings.most_points))
        if 'from' in query:
            begin, end = (_number(query, key, 0.0) for key in ('from', 'to'))
            if end <= begin:
                raise ValueError('ask for a `to` that lies behind `from`')
            return Seen(origin + round(begin * 1e9), origin + round(end * 1e9), origin, most)
        span = _number(query, 'span', 0.0)
        begin_at = max(oldest, newest - round(span * 1e9)) if span > 0.0 else oldest
        return Seen(begin_at, newest, origin, most)

    def _words(self, known: Presence) -> tuple[str, bool]:
        """Return how an estimator is, in a sentence, and whether that is well."""
        now = time.monotonic()
        if not known.present:
            ago = now - known.since
            return (
                f'gone for {ago:.0f} s: nothing publishes its topics; what was heard stays',
                False,
            )
        told = f': {known.health}' if known.health else ''
        if known.heard is None:
            return f'no estimate heard yet{told}', False
        if (silence := now - known.heard) > self._settings.silent:
            return f'silent for {silence:.0f} s{told}', False
        return known.health or 'heard', known.level == 0


def _number(query: Mapping[str, Sequence[str]], key: str, default: float) -> float:
    if key not in query:
        return default
    try:
        value = float(query[key][0])
    except (ValueError, IndexError):
        value = math.nan
    if not abs(value) < 1e10:  # s: with stamps since 1970, and for NaN
        raise ValueError(f'give {key} as a number of seconds')
    return value
