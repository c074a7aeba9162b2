"""Inputs that act late: steps of a rollout, cut where the late input changes.

An input that is held leaps at its samples, and one on straight lines has kinks there. With a dead
time of its own for each candidate, these lie anywhere within the steps of a window. Steps are
therefore cut at the changes, candidate by candidate: every piece sees a straight line, so that an
integrator errs no more than without a delay, and states are smooth in the delay.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from obs_ros.core.typing import Array, IntArray


class Changes(NamedTuple):
    """An input as straight lines: from t[k] s on, of t (L + 1,), it is u[k] + slope[k] s.

    The first line stands for all that is before, and t[0] is no change.
    """

    t: Array
    u: Array
    slope: Array

    def after(self, count: IntArray, at: Array) -> tuple[Array, Array]:
        """Return value and slope at times `at`, by the numbers of changes up to then."""
        slope = self.slope[count]
        return self.u[count] + slope * (at - self.t[count]), slope


@dataclass(frozen=True, eq=False)
class InputPath:
    """The inputs of a window and before it, as they were sent.

    From t[k] s on, of t (L,), they are u[k] + s slope[k] after s seconds, with u and slope (L, m),
    and before the first as at it.
    """

    t: Array
    u: Array
    slope: Array

    def changes(self, column: int) -> Changes:
        """Return one input as the lines that differ from those before."""
        t, u, slope = self.t, self.u[:, column], self.slope[:, column]
        foretold = u[:-1] + slope[:-1] * np.diff(t)
        other = (u[1:] != foretold) | (slope[1:] != slope[:-1])
        rows = np.flatnonzero(np.append(slope[0] != 0.0, other))
        return Changes(*(np.append(first, each[rows]) for first, each in (
            (t[0], t), (u[0], u), (0.0, slope)
        )))  # fmt: skip


class Pieces(NamedTuple):
    """The steps of B candidates in pieces, as many for each: piece g goes from t[g] to t[g + 1].

    t (G + 1, B) in s; step f begins at first[f], of (F + 1,); changed[i] (G + 1, B) counts the
    changes of input i up to each beginning.
    """

    t: Array
    first: IntArray
    changed: list[IntArray]

    @classmethod
    def of(cls, t: Array, late: Sequence[Array], candidates: int) -> 'Pieces':
        """Cut the steps between times t (F + 1,) at changes: `late` (L, B) for each input.

        A candidate with fewer changes in a step than others has its last piece there in equal
        parts.
        """
        shape = t.size - 1, candidates
        at = np.concatenate([np.empty((0, candidates)), *late])
        owner = np.repeat(np.arange(len(late)), [len(each) for each in late])[:, None]
        if len(late) > 1:
            order = np.argsort(at, axis=0, kind='stable')
            at, owner = np.take_along_axis(at, order, axis=0), owner[order, 0]
        step = np.searchsorted(t, at, side='right') - 1
        inside = (step >= 0) & (step < shape[0])
        inside &= at > t[step]
        row, lane = np.nonzero(inside)
        own = step[row, lane]
        counts = np.bincount(own * candidates + lane, minlength=t.size * candidates)
        counts = counts.reshape(t.size, candidates)[:-1]
        pieces = 1 + counts.max(axis=1)
        first = np.append(0, np.cumsum(pieces))
        before = np.cumsum(counts, axis=0) - counts
        place = first[np.maximum(step, 0)]
        place[row, lane] += np.cumsum(inside, axis=0)[row, lane] - before[own, lane]
        ends = _laid(t, pieces, first, counts, (place[row, lane], lane, at[row, lane]))
        cells = place * candidates + np.arange(candidates)
        changed = []
        for i in range(len(late)):
            begun = cells[(owner == i) & (at <= t[-1])]
            here = np.bincount(begun, minlength=ends.size).reshape(ends.shape)
            changed.append(np.cumsum(here, axis=0))
        return cls(ends, first, changed)


def _laid(
    t: Array,
    pieces: IntArray,
    first: IntArray,
    counts: IntArray,
    cuts: tuple[IntArray, IntArray, Array],
) -> Array:
    """Return the ends (G + 1, B) of pieces: cuts are places, candidates and times."""
    step = np.repeat(np.arange(pieces.size), pieces)
    rank = (np.arange(step.size) - first[step])[:, None]
    ends = np.append(t[step], t[-1])[:, None].repeat(counts.shape[1], axis=1)
    place, lane, at = cuts
    ends[place, lane] = at
    known = counts[step]
    more = rank > known
    if more.any():
        last = np.take_along_axis(ends, first[step][:, None] + known, axis=0)
        share = (rank - known) / (pieces[step][:, None] - known)
        ends[:-1] = np.where(more, last + share * (t[step + 1][:, None] - last), ends[:-1])
    return ends
