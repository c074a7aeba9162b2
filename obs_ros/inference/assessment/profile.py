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
from obs_ros.core.jit import accelerated
from obs_ros.core.typing import AnyArray, Array, BoolArray, IntArray
from obs_ros.inference.prior import Posterior
from obs_ros.optimization.lm_linalg import TINY, solved


@dataclass(frozen=True)
class ProfileSettings:
    """Limits of the search for the ends of profiles.

    - `growth`: of the cost at the ends, in units of the noise: 95 % two-sided;
    - `like_parabola`: share of that by which the cost may differ at the parabola's ends, whose
      deviations then stand;
    - `iterations`: rollouts at most; an end that takes more is not told;
    - `tolerance`: share of the growth within which an end is found;
    - `first_reach`, `most_reach` (boxes): of a first step, and of any;
    - `faster`, `slower`: factors of the reach after a step that was foretold well, or badly;
    - `foretold`, `beyond`: shares of the growth by which the cost may differ from that foretold,
      and pass the level, for a step to be good, and to be taken at all;
    - `better`: squares below the optimum that show another, better one.
    """

    growth: float = 3.84
    like_parabola: float = 0.2
    iterations: int = 60
    tolerance: float = 0.05
    first_reach: float = 0.1
    most_reach: float = 0.3
    faster: float = 2.0
    slower: float = 0.35
    foretold: float = 0.25
    beyond: float = 1.0
    better: float = 0.5


PROFILE = ProfileSettings()


@dataclass(frozen=True)
class Ends:
    """Ends of the profiles of some unknowns (E,): first all lower ends, then all upper ones.

    `points` (E, d) are the optima there, `growth` (E,) that of the cost above the least. An end
    that is not `closed` (E,) is no end: the profile goes on, or stops at a bound. `better` (d,) is
    a point of less cost than the optimum, None where there is none.
    """

    pinned: IntArray
    points: Array
    growth: Array
    closed: BoolArray
    better: Array | None = None


def parabola_holds(
    posterior: Posterior,
    z: Array,
    covariance: Array,
    level: float,
    settings: ProfileSettings = PROFILE,
) -> bool:
    """Whether the cost grows by `level` where the parabola of a covariance (d, d) says so.

    That is at both ends of each unknown's interval, the others moving along; all must be inside the
    limits.
    """
    if not np.isfinite(covariance).all():
        return False
    deviations = np.sqrt(np.maximum(np.diagonal(covariance), TINY))
    along = np.sqrt(level) * (covariance / deviations).T
    points = np.vstack([z[None], z - along, z + along])
    if not ((points >= posterior.limits[0]) & (points <= posterior.limits[1])).all():
        return False
    costs = posterior.costs(points)
    growth = (costs[1:] - costs[0]) / level
    return bool((np.abs(growth - 1.0) <= settings.like_parabola).all())


def profile_ends(
    posterior: Posterior,
    z: Array,
    pinned: IntArray,
    reach: Array,
    level: float,
    probe: float,
    deadline: Deadline,
    settings: ProfileSettings = PROFILE,
) -> Ends:
    """Return the ends of the profiles of the unknowns `pinned` (q,) around an optimum z (d,).

    A profile is followed over `reach` (q,) at most, in boxes; `level` is the growth of the cost at
    the ends, `probe` the step (box) of differences.
    """
    return _Walk(posterior, z, pinned, reach, level, probe, settings).run(deadline)


class _Walk:
    """All ends of the profiles of one window, on their way."""

    def __init__(
        self,
        posterior: Posterior,
        z: Array,
        pinned: IntArray,
        reach: Array,
        level: float,
        probe: float,
        settings: ProfileSettings,
    ) -> None:
        self._posterior, self._settings = posterior, settings
        self._level, self._probe = level, probe
        q = pinned.size
        self.pinned = np.tile(pinned, 2)
        self.side = np.repeat([-1.0, 1.0], q)
        self.start = z
        self.points = np.repeat(z[None], 2 * q, axis=0)
        self.growth = np.zeros(2 * q)
        self.closed = np.zeros(2 * q, dtype=np.bool_)
        self._most = np.tile(reach, 2)
        self._radius = np.full(2 * q, settings.first_reach)
        self._damping = np.full(2 * q, 1.0)
        squares, gradient, hessian = self._linearised(z[None])
        self._least = float(squares[0])
        self._squares = np.full(2 * q, squares[0])
        self._gradient = np.repeat(gradient, 2 * q, axis=0)
        self._hessian = np.repeat(hessian, 2 * q, axis=0)

    def _linearised(self, points: Array) -> tuple[Array, Array, Array]:
        steps = np.full_like(points, self._probe)
        return self._posterior.linearise(points, steps, self._posterior.nodes)

    def run(self, deadline: Deadline) -> Ends:
        """Walk until every end is found, or given up."""
        under_way = np.arange(self.side.size)
        better = None
        s, limits, level = self._settings, self._posterior.limits, self._level
        for _ in range(s.iterations):
            if deadline.passed:
                break
            step, excess, foretold = profile_steps(
                self.points[under_way],
                self._squares[under_way],
                self._gradient[under_way],
                self._hessian[under_way],
                self.pinned[under_way],
                self.side[under_way],
                self._radius[under_way],
                self._damping[under_way],
                self._least,
                level,
                limits,
            )
            under_way, step, foretold = self._settle(under_way, step, excess, foretold)
            if not under_way.size:
                break
            trial = self.points[under_way] + step
            squares, gradient, hessian = self._linearised(trial)
            fine = np.isfinite(squares) & np.isfinite(hessian).all(axis=(1, 2))
            squares = np.where(fine, squares, np.inf)
            before = self._squares[under_way]
            ceiling = np.maximum(before, self._least + level) + s.beyond * level
            taken = squares <= ceiling
            good = np.abs(squares - foretold) <= s.foretold * level
            lane = under_way[taken]
            self.points[lane], self._squares[lane] = trial[taken], squares[taken]
            self._gradient[lane], self._hessian[lane] = gradient[taken], hessian[taken]
            moved = np.abs(step).max(axis=1)
            radius = self._radius[under_way]
            radius = np.where(taken & good, np.maximum(radius, s.faster * moved), radius)
            radius = np.where(taken, radius, s.slower * moved)
            damping = self._damping[under_way] * np.where(taken & good, 0.2, 1.0)
            self._damping[under_way] = np.where(taken, damping, 10.0 * damping)
            self._radius[under_way] = np.minimum(radius, s.most_reach)
            lowest = int(np.argmin(squares))
            if squares[lowest] < self._least - s.better:
                better = trial[lowest]
                break
        return Ends(self.pinned, self.points, self.growth, self.closed, better)

    def _settle(
        self, under_way: IntArray, step: Array, excess: Array, foretold: Array
    ) -> tuple[IntArray, Array, Array]:
        """Take out the walks that are over; return the others with their steps."""
        s, limits, level = self._settings, self._posterior.limits, self._level
        k = self.pinned[under_way]
        here = self.points[under_way, k]
        floor = self._squares[under_way] - excess - self._least
        self.growth[under_way] = np.maximum(floor, 0.0)
        straight = excess <= s.tolerance * level
        at_level = straight & (np.abs(floor - level) <= s.tolerance * level)
        gone = np.abs(here - self.start[k])
        at_limit = np.where(self.side[under_way] > 0.0, here >= limits[1, k], here <= limits[0, k])
        far = straight & (floor < level) & (at_limit | (gone > self._most[under_way]))
        ended = under_way[at_level]
        self.points[ended] = np.clip(self.points[ended] + step[at_level], *limits)
        self.growth[ended] = level
        self.closed[ended] = True
        left = ~(at_level | far)
        return under_way[left], step[left], foretold[left]


@accelerated
def profile_steps(
    z: Array,
    squares: Array,
    gradient: Array,
    hessian: Array,
    pinned: AnyArray,
    side: Array,
    radius: Array,
    damping: Array,
    least: float,
    growth: float,
    limits: Array,
) -> tuple[Array, Array, Array]:
    """Return steps (P, d), what the others may still gain (P,), and the cost foretold (P,).

    From points z (P, d) with squares (P,), J'r (P, d) and J'J (P, d, d). Unknown `pinned` (P,)
    moves to the `side` (P,) on which the profile has grown by `growth` above the `least`, the
    others to their optimum inside the limits (2, d), with a `damping` (P,) of steps in boxes. No
    unknown follows the pinned one by more than the `radius` (P,); that one waits as long as much is
    to gain.
    """
    count, d = z.shape
    step = np.zeros((count, d))
    excess, foretold = np.zeros(count), np.zeros(count)
    free = np.zeros(d, dtype=np.bool_)
    for s in range(count):
        k, g, curve = pinned[s], gradient[s], hessian[s]
        down = to_optimum(z[s], g, curve, damping[s], k, 0.0, limits, free)
        excess[s] = -change(g, curve, down)
        lean = solved(curve, np.ones(d), damping[s], curve[k], free)
        curvature, slope = curve[k, k], g[k]
        for i in range(d):
            slope += curve[k, i] * down[i]
            if free[i]:
                curvature -= curve[k, i] * lean[i]
        gap = squares[s] - excess[s] - least - growth
        root = slope * slope - curvature * gap
        move = side[s]
        if curvature > 0.0 and root > 0.0:
            move = (-slope + side[s] * np.sqrt(root)) / curvature
        elif curvature > 0.0 and gap > 0.0:  # the floor is above the level everywhere near
            move = -slope / curvature
        move = min(max(move, -radius[s]), radius[s])
        move = min(max(z[s, k] + move, limits[0, k]), limits[1, k]) - z[s, k]
        share = 0.0
        along = down
        if excess[s] < 0.5 * growth:
            along = to_optimum(z[s], g, curve, damping[s], k, move, limits, free) - down
            share = radius[s] / max(radius[s], np.abs(along).max())
        for i in range(d):
            aim = z[s, i] + down[i] + share * along[i]
            step[s, i] = min(max(aim, limits[0, i]), limits[1, i]) - z[s, i]
        foretold[s] = squares[s] + change(g, curve, step[s])
    return step, excess, foretold


@accelerated
def to_optimum(
    z: Array, gradient: Array, hessian: Array, damping: float, pinned: int, move: float,
    limits: Array, free: BoolArray,
) -> Array:  # fmt: skip
    """Return the step (d,) of least cost in which one unknown makes this move, inside the limits.

    Those that would leave the limits stop there; `free` (d,) becomes those that do not.
    """
    d = z.size
    step, scale = np.zeros(d), np.ones(d)
    step[pinned] = move
    for i in range(d):
        outward = (z[i] <= limits[0, i] and gradient[i] > 0.0) or (
            z[i] >= limits[1, i] and gradient[i] < 0.0
        )
        free[i] = i != pinned and not outward
    for _ in range(d):
        right = np.zeros(d)
        for i in range(d):
            right[i] = -gradient[i]
            for j in range(d):
                if not free[j]:
                    right[i] -= hessian[i, j] * step[j]
        found = solved(hessian, scale, damping, right, free)
        inside = True
        for i in range(d):
            if not free[i]:
                continue
            step[i] = found[i]
            aim = min(max(z[i] + found[i], limits[0, i]), limits[1, i])
            if aim != z[i] + found[i]:
                step[i] = aim - z[i]
                free[i] = inside = False
        if inside:
            break
    return step


@accelerated
def change(gradient: Array, hessian: Array, step: Array) -> float:
    """Return by how much a step (d,) changes the cost, by the quadratic model."""
    total = 0.0
    for i in range(step.size):
        pull = 2.0 * gradient[i]
        for j in range(step.size):
            pull += hessian[i, j] * step[j]
        total += pull * step[i]
    return total
