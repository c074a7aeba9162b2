"""Profile likelihood: how far each unknown may go until the window contradicts it.

The profile of unknown k is the least cost with z_k held at a value, all others optimised within
their limits. Its ends are the values at which the cost has grown by 3.84, the 95 % quantile of a
chi-square of one degree of freedom (Raue et al. 2009, Bioinformatics 25, 1923-1929). Unlike the
parabola at the optimum they follow bent valleys, and stop at bounds.

All ends are sought at once, on one batched rollout for each step: that of Venzon & Moolgavkar
(1988, Applied Statistics 37, 87-94), which moves z_k to where a local quadratic model of the
profile reaches the level, and the others to their optimum there.
"""

from dataclasses import dataclass

import numpy as np

from obs_ros.core.deadline import Deadline
from obs_ros.core.linear_algebra import eigen
from obs_ros.core.typing import Array, BoolArray, IntArray
from obs_ros.inference.assessment.profile_steps import (
    Places,
    change,
    profile_steps,
    to_optimum,
)
from obs_ros.inference.jumps.piecewise import PiecewiseProblem
from obs_ros.inference.prior import Posterior
from obs_ros.optimization.lm_linalg import TINY


@dataclass(frozen=True)
class ProfileSettings:
    """Limits of the search for the ends of profiles.

    - `growth`: of the cost at the ends, in units of the noise: 95 % two-sided;
    - `iterations`: rollouts at most; an end that takes more is not told;
    - `tolerance`: share of the growth within which an end is found, and `wait`: the one that the
      others may still gain as the pinned one moves on. At a kink a walk goes to and fro: after each
      `patience` rollouts as much again is allowed, up to `loosest`, and the wait is longer;
    - `first_reach`, `most_reach` (boxes): of a first step, and of any;
    - `damping`: of the others' first steps, an information per box squared, and its factors
      `less_damping` and `more_damping` after a good step and a bad one;
    - `faster`, `slower`: factors of the reach after a step that was foretold well, or badly;
    - `foretold`, `beyond`: shares of the growth by which the cost may differ from that foretold,
      and pass the level, for a step to be good, and to be taken at all;
    - `better`: squares below the optimum that show another, better one;
    - `beside` (boxes): how far beside an end the valley is looked at, at most;
    - `restarts`: of a profile from a point of another one that lies beyond its end.
    """

    growth: float = 3.84
    iterations: int = 60
    tolerance: float = 0.05
    patience: int = 10
    loosest: float = 0.2
    wait: float = 0.5
    first_reach: float = 0.1
    most_reach: float = 0.3
    damping: float = 1.0
    less_damping: float = 0.2
    more_damping: float = 10.0
    faster: float = 2.0
    slower: float = 0.35
    foretold: float = 0.25
    beyond: float = 1.0
    better: float = 0.5
    beside: float = 0.1
    restarts: int = 2


PROFILE = ProfileSettings()


@dataclass(frozen=True)
class Ends:
    """Ends of the profiles of some unknowns (E,): first all lower ends, then all upper ones.

    `middle` (d,) is the optimum, `points` (E, d) are those at the ends, `growth` (E,) that of the
    cost above the least. An end that is not `closed` (E,) is no end: the profile goes on, or stops
    at a bound. `better` (d,) is a point of less cost than the optimum, None where there is none.
    `visited` (V, d) are the points that were met and cost no more than the ends, and some beside
    these, `costs` (V,) how much more than the least.
    """

    pinned: IntArray
    middle: Array
    points: Array
    growth: Array
    closed: BoolArray
    visited: Array
    costs: Array
    better: Array | None = None


def profile_ends(
    posterior: Posterior | PiecewiseProblem,
    z: Array,
    pinned: IntArray,
    reach: Array,
    level: float,
    probe: float,
    deadline: Deadline,
    others: Array | None = None,
    settings: ProfileSettings = PROFILE,
) -> Ends:
    """Return the ends of the profiles of the unknowns `pinned` (q,) around an optimum z (d,).

    A profile is followed over `reach` (q,) at most, in boxes; `level` is the growth of the cost at
    the ends, `probe` the step (box) of differences. `others` (B, d) are other optima.
    """
    walk = _Walk(posterior, z, pinned, reach, level, probe, settings)
    if others is not None and len(others):
        walk.note(others)
    return walk.run(deadline)


class _Walk:
    """All ends of the profiles of one window, on their way: a lane for each end."""

    def __init__(
        self,
        posterior: Posterior | PiecewiseProblem,
        z: Array,
        pinned: IntArray,
        reach: Array,
        level: float,
        probe: float,
        settings: ProfileSettings,
    ) -> None:
        self._posterior, self._settings = posterior, settings
        self._level, self._probe, self._start = level, probe, z
        self._tolerance, self._wait = settings.tolerance, settings.wait
        lanes = 2 * pinned.size
        self._pinned, self._most = np.tile(pinned, 2), np.tile(reach, 2)
        self._side = np.repeat([-1.0, 1.0], pinned.size)
        self._growth, self._closed = np.zeros(lanes), np.zeros(lanes, dtype=np.bool_)
        self._radius = np.full(lanes, settings.first_reach)
        self._damping = np.full(lanes, settings.damping)
        self._fresh = np.full(lanes, settings.restarts)
        found = self._posterior.linearise(z[None], np.full((1, z.size), probe), posterior.nodes)
        # A search ends where hardly anything is left to gain: the rest of the way is foretold.
        free = np.zeros(z.size, dtype=np.bool_)
        down = to_optimum(
            z, found[1][0], found[2][0], settings.damping, -1, 0.0, posterior.limits, free
        )
        gain = -change(found[1][0], found[2][0], down)
        near = 0.0 <= gain < settings.better
        self._middle = z + down if near else z
        self._least = float(found[0][0]) - (gain if near else 0.0)
        self._here = Places.repeated(z[None], *found, lanes)
        self._visited: list[Array] = []
        self._costs: list[Array] = []
        # Any point of no more cost shows how far each unknown may go.
        self._furthest = Places.repeated(z[None], *found, lanes)

    def run(self, deadline: Deadline) -> Ends:
        """Walk until every end is found, or given up."""
        lanes, better = np.arange(self._side.size), None
        for k in range(self._settings.iterations):
            looser = self._settings.tolerance * (1 + k // self._settings.patience)
            self._tolerance = min(looser, self._settings.loosest)
            self._wait = self._settings.wait / (1 + k // self._settings.patience)
            lanes, step, foretold = self._settled(lanes, *self._steps(lanes))
            if not lanes.size:
                lanes = self._begun_anew()
                lanes, step, foretold = self._settled(lanes, *self._steps(lanes))
            if not lanes.size or deadline.passed:
                break
            trial = self._linearised(self._here.points[lanes] + step)
            self._move(lanes, trial, step, foretold)
            lowest = int(np.argmin(trial.squares))
            if trial.squares[lowest] < self._least - self._settings.better:
                better = trial.points[lowest]
                break
        self._closed[lanes] = False
        beside, wide = self._beside()
        return Ends(
            self._pinned,
            self._middle,
            self._here.points,
            self._growth,
            self._closed,
            np.concatenate([self._here.points, *beside, *self._visited]),
            np.concatenate([self._growth, *wide, *self._costs]),
            better,
        )

    def _beside(self) -> tuple[list[Array], list[Array]]:
        """Return points beside each end, where a valley may be wider, and their costs.

        They lie along the axes of the curvature, as far as that alone would cost the level.
        """
        points, costs, here, limits = [], [], self._here, self._posterior.limits
        lanes = zip(here.points, self._growth, here.gradient, here.hessian, strict=True)
        for z, growth, g, hessian in lanes:
            curvatures, axes = eigen(hessian)
            steps = np.sqrt(self._level / np.maximum(curvatures, TINY))
            off = axes.T * np.minimum(steps, self._settings.beside)[:, None]
            points.append(np.clip(np.vstack([z - off, z + off]), *limits))
            off = points[-1] - z
            costs.append(growth + 2.0 * off @ g + ((off @ hessian) * off).sum(axis=1))
        return points, costs

    def _steps(self, lanes: IntArray) -> tuple[Array, Array, Array]:
        here = self._here
        return profile_steps(
            here.points[lanes],
            here.squares[lanes],
            here.gradient[lanes],
            here.hessian[lanes],
            self._pinned[lanes],
            self._side[lanes],
            self._radius[lanes],
            self._damping[lanes],
            self._least,
            self._level,
            self._wait,
            self._posterior.limits,
        )

    def _linearised(self, points: Array) -> Places:
        steps = np.full_like(points, self._probe)
        found = self._posterior.linearise(points, steps, self._posterior.nodes)
        fine = np.isfinite(found[0]) & np.isfinite(found[2]).all(axis=(1, 2))
        return Places(points, np.where(fine, found[0], np.inf), *found[1:])

    def _settled(
        self, lanes: IntArray, step: Array, excess: Array, foretold: Array
    ) -> tuple[IntArray, Array, Array]:
        """Take out the lanes that are over; return the others with their steps."""
        limits, level = self._posterior.limits, self._level
        k, side = self._pinned[lanes], self._side[lanes]
        at = self._here.points[lanes, k]
        floor = self._here.squares[lanes] - excess - self._least
        self._growth[lanes] = np.maximum(floor, 0.0)
        straight = excess <= self._tolerance * level
        at_level = straight & (np.abs(floor - level) <= self._tolerance * level)
        at_limit = np.where(side > 0.0, at >= limits[1, k], at <= limits[0, k])
        gone = at_limit | (np.abs(at - self._start[k]) > self._most[lanes])
        left = ~(at_level | (straight & (floor < level) & gone))
        ended = lanes[at_level]
        end = np.clip(self._here.points[ended] + step[at_level], *limits)
        moved = (end - self._here.points[ended])[:, :, None]
        self._here.gradient[ended] += (self._here.hessian[ended] @ moved)[:, :, 0]
        self._here.points[ended] = end
        self._growth[ended], self._closed[ended] = level, True
        return lanes[left], step[left], foretold[left]

    def _move(self, lanes: IntArray, trial: Places, step: Array, foretold: Array) -> None:
        """Take the trials that are near what was foretold, and adapt reach and damping."""
        s, level = self._settings, self._level
        before = self._here.squares[lanes]
        ceiling = np.maximum(before, self._least + level) + s.beyond * level
        # While the pinned one waits, the others go down: at a kink they would go to and fro.
        waits = step[np.arange(lanes.size), self._pinned[lanes]] == 0.0
        taken = trial.squares <= np.where(waits, before, ceiling)
        good = taken & (np.abs(trial.squares - foretold) <= s.foretold * level)
        self._here.put(lanes[taken], trial, taken)
        moved = np.abs(step).max(axis=1)
        radius = np.where(good, np.maximum(self._radius[lanes], s.faster * moved), s.slower * moved)
        radius = np.where(taken & ~good, self._radius[lanes], radius)
        self._radius[lanes] = np.minimum(radius, s.most_reach)
        factor = np.where(good, s.less_damping, np.where(taken, 1.0, s.more_damping))
        self._damping[lanes] *= factor
        self._note(trial)

    def note(self, points: Array) -> None:
        """Note how far points (B, d) lie that cost no more than the ends."""
        self._note(self._linearised(points))

    def _note(self, trial: Places) -> None:
        """Note which points of no more cost than the ends lie furthest, by each unknown."""
        allowed = np.flatnonzero(trial.squares <= self._least + self._level)
        if allowed.size:
            self._visited.append(trial.points[allowed])
            self._costs.append(np.maximum(trial.squares[allowed] - self._least, 0.0))
            places = self._side[:, None] * trial.points[allowed][:, self._pinned].T
            best = places.argmax(axis=1)
            every = np.arange(self._side.size)
            known = self._side * self._furthest.points[every, self._pinned]
            beyond = np.flatnonzero(places[every, best] > known)
            self._furthest.put(beyond, trial, allowed[best[beyond]])

    def _begun_anew(self) -> IntArray:
        """Return the lanes that another has shown to end too early, to go on from there."""
        every = np.arange(self._side.size)
        ends = self._here.points[every, self._pinned]
        further = self._side * (self._furthest.points[every, self._pinned] - ends)
        width = np.abs(ends - self._start[self._pinned])
        early = self._closed & (further > self._settings.tolerance * width) & (self._fresh > 0)
        lanes = np.flatnonzero(early)
        self._here.put(lanes, self._furthest, lanes)
        self._closed[lanes] = False
        self._radius[lanes] = self._settings.first_reach
        self._damping[lanes] = self._settings.damping
        self._fresh[lanes] -= 1
        return lanes
