"""How true jumps were announced, and which announcements belong to none."""

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from enum import StrEnum
from typing import NamedTuple

import numpy as np

from benchmarks.sequence.jumps_elsewhere.follow import Followed, Said
from benchmarks.sequence.plants import Change
from obs_ros.core.model import names
from obs_ros.core.typing import BoolArray

NEAR, NEAR_SD = 0.5, 3.0  # window lengths and sd, by which the time of a true jump may be missed
TOLD = 12.0  # -2 log likelihood: prior odds of 1:100, and about what a size and a time cost
DUE = 1.0 / 6.0  # of a window's length after a jump, that the window which must show it holds


class How(StrEnum):
    """The first announcement of a true jump."""

    RIGHT = 'named right'
    LISTED = 'misnamed, the truth is listed'
    MISNAMED = 'misnamed, not listed'
    MISSED = 'missed'


class Announced(NamedTuple):
    """A new jump in window `window`, the true jump that it is near, and what came of it.

    `back` is the window that takes it back, -1 if none does.
    """

    window: int
    said: Said
    change: Change | None
    right: bool
    back: int


class Verdict(NamedTuple):
    """How one true jump was announced; windows `window` to `until` (excluded) come after that.

    `late`: by no window that ends within DUE, nor by the first that ends later. `mended`: the right
    name was announced later on. `back`: the first announcement was taken back. `time_error` in
    window lengths and s; NaN of a jump that was missed.
    """

    how: How
    late: bool
    mended: bool
    back: bool
    window: int
    until: int
    time_error: float
    time_z: float
    probability: float
    size: float


def name_of(run: Followed, change: Change) -> str:
    """Return the name of the parameter that jumps."""
    return names(run.scene.experiment.model.parameters)[change.place]


def announcements(run: Followed) -> list[Announced]:
    """Return all new jumps of a run that are no retractions."""
    found = []
    for k, said in enumerate(run.said):
        for one in said:
            if one.new and not one.retracted:
                change = _nearest(run, k, one)
                right = change is not None and one.names == {name_of(run, change)}
                found.append(Announced(k, one, change, right, _taken_back(run, k, one)))
    return found


def false_jumps(run: Followed) -> list[Announced]:
    """Return the new jumps that are near no true one."""
    return [each for each in announcements(run) if each.change is None]


def verdicts(run: Followed) -> Iterator[Verdict]:
    """Judge every true jump of a run."""
    own: Mapping[Change, list[Announced]] = defaultdict(list)
    for each in announcements(run):
        if each.change is not None:
            own[each.change].append(each)
    later = [*run.changes[1:], None]
    for change, following in zip(run.changes, later, strict=False):
        until = len(run.end) if following is None else holding(run, following)
        yield _verdict(run, change, own.get(change, []), until)


def holding(run: Followed, change: Change) -> int:
    """Return the first window that holds a sample after a jump."""
    return int(np.flatnonzero(run.end > change.time)[0])


def due(run: Followed, change: Change) -> int:
    """Return the window that must show a jump; the last one where none holds enough."""
    late = np.flatnonzero(run.end >= change.time + DUE * run.scene.length)
    return int(late[0]) if late.size else len(run.end) - 1


def settled(run: Followed) -> BoolArray:
    """Return the windows (W,) that do not end within DUE after a jump, too soon to show it."""
    chosen = np.ones(len(run.end), dtype=np.bool_)
    for change in run.changes:
        chosen[holding(run, change) : due(run, change)] = False
    return chosen


def told(run: Followed) -> BoolArray:
    """Return the windows (W,) by whose end the best test could have told every jump so far.

    Of windows in whose run no error is far beyond its deviation that is not asked.
    """
    return np.asarray(run.visible >= TOLD)


def calm(run: Followed) -> BoolArray:
    """Return the windows (W,) in which nothing has jumped yet."""
    first = min((change.time for change in run.changes), default=np.inf)
    return np.asarray(run.end <= first)


def after(run: Followed, how: Sequence[How]) -> BoolArray:
    """Return the windows (W,) that follow a jump which was announced in one of these ways."""
    chosen = np.zeros(len(run.end), dtype=np.bool_)
    for verdict in verdicts(run):
        if verdict.how in how:
            chosen[verdict.window : verdict.until] = True
    return chosen


def _verdict(run: Followed, change: Change, own: Sequence[Announced], until: int) -> Verdict:
    name = name_of(run, change)
    model = run.scene.experiment.model
    box = model.parameters[change.place]
    size = abs(change.size) / (box.upper - box.lower)
    last = due(run, change)
    if not own:
        return Verdict(
            How.MISSED, False, False, False, last, until, np.nan, np.nan, np.nan, size
        )  # fmt: skip
    first = own[0]
    wrong = How.LISTED if name in first.said.alternatives else How.MISNAMED
    return Verdict(
        how=How.RIGHT if first.right else wrong,
        late=first.window > last,
        mended=not first.right and any(each.right for each in own[1:]),
        back=first.back >= 0,
        window=first.window,
        until=max(until, first.window + 1),
        time_error=abs(first.said.time - change.time),
        time_z=abs(first.said.time - change.time) / max(first.said.time_sd, 1e-12),
        probability=first.said.probability,
        size=size,
    )


def _nearest(run: Followed, window: int, said: Said) -> Change | None:
    within = max(NEAR * run.scene.length, NEAR_SD * said.time_sd)
    near = [
        change for change in run.changes
        if change.time < run.end[window] and abs(change.time - said.time) <= within
    ]  # fmt: skip
    return min(near, key=lambda change: abs(change.time - said.time), default=None)


def _taken_back(run: Followed, window: int, said: Said) -> int:
    within = max(NEAR * run.scene.length, NEAR_SD * said.time_sd)
    for k in range(window, len(run.said)):
        for other in run.said[k]:
            if other.retracted and other.names >= said.names and (
                abs(other.time - said.time) <= within
            ):  # fmt: skip
                return k
    return -1
