"""Steps of each candidate's own: a linearly implicit method that controls its local error.

A candidate goes from node to node in steps h whose embedded error estimate e (n,), the difference
of the methods of order 3 and 2, is small beside its states x before and after (Hairer & Wanner
1996, section IV.8):

    |e_i / (tolerance (floor_i + max |x_i|))|, root of the sum of squares, <= 1

A step that errs by more is taken again, shorter. Candidates of one group take the steps of its
leader: they differ from it so little that their differences are derivatives. Where inputs leap, and
at the begin, the first step is short beside the rate at which states move: a linearly implicit
method damps a fast start whether its steps resolve it or not, and its estimate does too.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from obs_ros.core.model import Model, inside
from obs_ros.core.typing import Array, BoolArray, IntArray
from obs_ros.integration.grid import Grid
from obs_ros.integration.path import LANES
from obs_ros.integration.steps import estimated


@dataclass(frozen=True)
class StepControl:
    """Control of steps.

    - `floor`: of a state's range, below which it counts as so much: what crosses 0 has a size;
    - `first`: share of a state, or of `small` ranges if that is more, by which it may move in the
      first step after inputs leapt;
    - `safety`, `longer`, `shorter`: of the step that the error asks for; the most by which steps
      grow, and the least to which they shrink;
    - `low`: excess below which an error counts as so much;
    - `stalled`: of what is left to the next node, below which a step leads nowhere.
    """

    floor: float = 1e-6
    first: float = 0.01
    small: float = 1e-3
    safety: float = 0.9
    longer: float = 5.0
    shorter: float = 0.1
    low: float = 1e-8
    stalled: float = 1e-15


CONTROL = StepControl()


def floors(model: Model) -> Array:
    """Return the sizes (n,) that states have at least, by which their errors are judged."""
    widths = [
        v.upper - v.lower if np.isfinite(v.upper - v.lower) else abs(inside(v)) or 1.0
        for v in model.states
    ]
    return CONTROL.floor * np.array(widths) + np.finfo(np.float64).tiny


@dataclass(frozen=True)
class Layout:
    """Candidates in chunks of lanes such that every group has its leader in each of its chunks.

    order (lanes,) are the candidates in the lanes, some more than once; lead (chunks, LANES) says
    for each lane where its leader is in the chunk; place (B,) is the lane of each candidate.
    """

    order: IntArray
    lead: IntArray
    place: IntArray

    @classmethod
    def of(cls, count: int, width: int) -> 'Layout':
        """Lay out so many candidates, groups of `width` neighbours led by the first of each."""
        order: list[int] = []
        lead: list[int] = []
        place = np.zeros(count, dtype=np.int64)
        for part in _parts(count, width):
            if len(part) > -len(order) % LANES:
                _fill(order, lead)
            begin = len(order)
            place[part] = begin + np.arange(len(part))
            order += part
            lead += [begin % LANES] * len(part)
        _fill(order, lead)
        return cls(np.array(order), np.array(lead).reshape(-1, LANES), place)


def _fill(order: list[int], lead: list[int]) -> None:
    """Repeat the last leader until its chunk is full."""
    if free := -len(order) % LANES:
        order += [order[len(order) // LANES * LANES + lead[-1]]] * free
        lead += [lead[-1]] * free


def _parts(count: int, width: int) -> list[list[int]]:
    """Return leaders, each with as many of its group as a chunk can hold beside it."""
    parts = []
    for first in range(0, count, width):
        others = range(first + 1, first + width)
        for at in range(0, max(1, width - 1), LANES - 1):
            parts.append([first, *others[at : at + LANES - 1]])
    return parts


def leaders(count: int, width: int) -> IntArray:
    """Return for each candidate (B,) which one leads its group of `width` neighbours."""
    return np.asarray(np.arange(count) // width * width)


def followed(
    model: Model,
    grid: Grid,
    nodes: int,
    x0: Array,
    p: Array,
    lead: IntArray,
    along: IntArray | None = None,
) -> tuple[Array, IntArray]:
    """Return the states (nodes, n, B) of candidates, and their steps (nodes - 1, B) in intervals.

    They start at x0 (n, B) with parameters p (q, B), or sets of them (S, q, B) of which along[k]
    (K,) holds in interval k; lead (B,) are their leaders. Those that take more than the grid's
    `budget` of steps, or that no steps lead on, are NaN from there on.
    """
    if along is None:
        p, along = p[None], np.zeros(max(1, nodes), dtype=np.int64)
    steps = _Steps(model, grid, nodes - 1, x0, p, along, lead)
    with np.errstate(all='ignore'):
        while steps.going.any():
            steps.advance()
    return steps.track, steps.counts


class _Steps:
    """Candidates on their way, each at a node and a time of its own."""

    def __init__(
        self,
        model: Model,
        grid: Grid,
        last: int,
        x0: Array,
        sets: Array,
        along: IntArray,
        lead: IntArray,
    ) -> None:
        count = x0.shape[1]
        self.model, self.grid, self.last, self.lead = model, grid, last, lead
        self.floor, self.sets, self.along = floors(model)[:, None], sets, along
        self.own = sets[along[0]].copy()  # the parameters (q, B) where each candidate is
        self.x = x0.copy()
        self.track = np.full((last + 1, *x0.shape), np.nan)
        self.track[0] = x0
        self.counts = np.zeros((max(last, 0), count), dtype=np.int64)
        self.node, self.taken = np.zeros((2, count), dtype=np.int64)
        self.dt, self.fresh = np.diff(grid.clock), grid.fresh
        self.h = np.full(count, grid.t[-1] - grid.t[0])
        self.left = np.full(count, self.dt[0] if last > 0 else 0.0)
        self.first = np.full(count, last > 0 and bool(self.fresh[0]))

    @property
    def going(self) -> BoolArray:
        """Which candidates (B,) are still on their way."""
        return np.asarray(self.node < self.last)

    def advance(self) -> None:
        """Try one step of every candidate."""
        grid, going = self.grid, self.going
        k = np.minimum(self.node, self.last - 1)
        s = self.dt[k] - self.left
        now, u0 = grid.clock[k] + s, self._inputs(k, s)
        if (going & self.first).any():
            self._begin(now, u0)
        step = np.minimum(self.h, grid.longest)
        step = np.where(self.left <= 1.01 * step, self.left,
                        np.where(self.left < 2.0 * step, 0.5 * self.left, step))  # fmt: skip
        step = np.where(going, step, 1.0)
        u2 = self._inputs(k, s + step)
        found = estimated(self.model.dynamics, now, step, tuple(self.x), u0, u2, tuple(self.own))
        y, e = (np.stack([np.broadcast_to(i, step.shape) for i in each]) for each in found)
        size = self.floor + np.maximum(np.abs(self.x), np.abs(y))
        error = np.sqrt(np.sum((e / (grid.tolerance * size)) ** 2, axis=0))[self.lead]
        self.taken += going
        self.counts[k[going], np.flatnonzero(going)] += 1
        self._judge(k, going, step, y, error)

    def _inputs(self, k: IntArray, s: Array) -> tuple[Any, ...]:
        return tuple((self.grid.u[k] + s[:, None] * self.grid.slope[k]).T)

    def _begin(self, now: Array, u0: tuple[Any, ...]) -> None:
        """Shorten the first step where inputs leapt."""
        rates = self.model.dynamics(now, tuple(self.x), u0, tuple(self.own))
        size = np.maximum(np.abs(self.x), CONTROL.small / CONTROL.floor * self.floor)
        moved = np.stack([np.broadcast_to(rate, now.shape) for rate in rates])
        rate = np.sqrt(np.sum((moved / size) ** 2, axis=0))
        short = (CONTROL.first / np.maximum(rate, np.finfo(np.float64).tiny))[self.lead]
        chosen = self.going & self.first & (short < self.h)
        self.h = np.where(chosen, short, self.h)
        self.first &= ~self.going

    def _judge(self, k: IntArray, going: BoolArray, step: Array, y: Array, error: Array) -> None:
        """Take the steps tried, or shorten them."""
        c = CONTROL
        good, bad = going & (error <= 1.0), going & ~(error <= 1.0)
        root = np.sqrt(np.maximum(error, c.low))
        longer = step * np.minimum(c.longer, c.safety / np.sqrt(root))
        longer = np.where(step < self.h, np.maximum(longer, self.h), longer)
        ratio = np.where(error < np.inf, np.maximum(c.shorter, c.safety / root), c.shorter)
        self.h = np.where(good, longer, np.where(bad, step * ratio, self.h))
        self.x = np.where(good, y, self.x)
        self.left = np.where(good, self.left - step, self.left)
        there = good & ~(self.left > 0.0)
        self.track[k[there] + 1, :, np.flatnonzero(there)] = self.x[:, there].T
        self.node = np.where(there, k + 1, self.node)
        later = np.minimum(self.node, self.last - 1)
        self.left = np.where(there, self.dt[later], self.left)
        changed = there & (self.along[later] != self.along[k])
        self.first = np.where(there, self.fresh[later] | changed, self.first)
        self.own[:, changed] = self.sets[self.along[later[changed]], :, np.flatnonzero(changed)].T
        lost = going & ~there & (self.taken >= self.grid.budget)
        lost |= bad & ~(self.h > c.stalled * self.dt[k])
        self.node = np.where(lost, self.last, self.node)
