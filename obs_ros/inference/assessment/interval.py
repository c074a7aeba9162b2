"""Two-sided intervals of a window's parameters and end states, by profiles where these are needed.

The cost of a window, squares of residuals and of what is known from elsewhere, is a parabola near
its optimum, whose curvature is the information. Where the inputs tell little, the valley of the
cost is bent, or ends at a bound: then intervals are those of the profile likelihood, see
`profile.py`. A box is a bound there, never a Gaussian.

What is handed on is Gaussian nevertheless. Its covariance C is that of the parabola, enlarged until
no point z_e that is met on a profile, at which the cost has grown by g_e, lies further than that:

    (z_e - z)' C^-1 (z_e - z) <= g_e.
"""

from dataclasses import dataclass

import numpy as np

from obs_ros.core.changes import replace
from obs_ros.core.deadline import Deadline
from obs_ros.core.estimate import QUANTILE
from obs_ros.core.linear_algebra import scaled_inverse
from obs_ros.core.typing import Array, BoolArray
from obs_ros.inference.assessment.identifiability import undetermined
from obs_ros.inference.assessment.parabola import parabola_holds
from obs_ros.inference.assessment.profile import PROFILE, Ends, profile_ends
from obs_ros.inference.jumps.hypothesis import Hypothesis, hypothesis_at
from obs_ros.inference.jumps.piecewise import PiecewiseProblem
from obs_ros.inference.parameterisation import BOX_VARIANCE, Unknowns
from obs_ros.inference.prior import Posterior
from obs_ros.optimization.levenberg_marquardt import Starts, levenberg_marquardt

WIDEST = 2.0 * QUANTILE  # in the deviations above which a parameter is not determined


@dataclass(frozen=True)
class IntervalSettings:
    """Limits in finding intervals.

    - `pulled`: squares that the optimum without the boxes may gain before it is published instead
      of that with them;
    - `polish`: iterations of a search from near an optimum;
    - `optima`: starts at most, each from a better optimum than the one before;
    - `scan`: iterations of a search for other optima;
    - `parts`: of a parameter's box, from the middles of which other optima are sought, and
      `groups` of parameters at most that are moved together: with many unknowns a start for each
      would take longer than all else;
    - `least_growth`: of the cost at a point, below which it counts as that: a valley is as long as
      it has been followed;
    - `rival`: growth of the cost, in units of the noise, up to which another optimum may be the
      true one, 99.9 % two-sided: in bent valleys the end of the interval is no wall;
    - `far`: times as far as a parabola through an end, from which on it is another optimum.
    """

    pulled: float = 0.1
    polish: int = 60
    optima: int = 3
    scan: int = 30
    parts: int = 3
    groups: int = 8
    least_growth: float = 1.0
    rival: float = 10.83
    far: float = 3.0


INTERVAL = IntervalSettings()


@dataclass(frozen=True)
class Interval:
    """95 % intervals (q,) of the estimated parameters, in boxes; NaN where a profile has no end.

    `middle` (q,) is the optimum between them, to which a search comes near. `states` (2, n) are
    the least and largest end states on the profiles, in their units.
    """

    lower: Array
    middle: Array
    upper: Array
    states: Array

    def told(self, unknowns: Unknowns) -> BoolArray:
        """Return which parameters (q,) have two ends, not too far apart to be determined."""
        limit = WIDEST * undetermined(unknowns)[unknowns.n_states :]
        return np.asarray(self.upper - self.lower <= limit)

    def widened(self, factors: Array) -> 'Interval':
        """Return intervals whose parts beside the middle are factors (q,) as long."""
        middle = self.middle
        lower = middle - factors * (middle - self.lower)
        return replace(self, lower=lower, upper=middle + factors * (self.upper - middle))


@dataclass(frozen=True)
class Determined:
    """A hypothesis with the covariance (D, D) of its point, and intervals where profiles tell them.

    Without intervals (None) those of the covariance hold.
    """

    hypothesis: Hypothesis
    covariance: Array
    interval: Interval | None = None


def determined(
    best: Hypothesis,
    inflation: float,
    deadline: Deadline,
    *,
    movable: bool = True,
    profiled: bool = True,
) -> Determined:
    """Return what a window says of its unknowns, which the boxes bound, but do not pull.

    `inflation` of the variances counts for the growth of the cost. A `movable` point goes to the
    optimum without the boxes where these pull, and to a better one that is met, and other optima
    are sought; one with jumps stays. Without `profiled` the covariance stands for all intervals.
    """
    level = PROFILE.growth * max(1.0, inflation)
    movable = movable and not best.problem.events
    optima = None  # those of one search: they stay, wherever the point goes
    for attempt in range(INTERVAL.optima):
        covariance = covariance_without_boxes(best)
        if movable and _pull(best, covariance) > INTERVAL.pulled:
            best = _polished(best, best.point, deadline)
            covariance = covariance_without_boxes(best)
        if not (profiled and np.isfinite(covariance).all()):
            break
        posterior, pinned = _posterior(best), best.final_parameters
        gradient = _gradient(best)
        if parabola_holds(posterior, best.point, gradient, covariance, pinned, level):
            break
        if movable and isinstance(posterior, Posterior):
            if optima is None:
                optima = _other_optima(posterior, best.point, deadline)
            least = float(posterior.costs(best.point[None])[0])
            lower = optima.squares[0] < least - PROFILE.better
            if lower and attempt + 1 < INTERVAL.optima:
                best = _polished(best, optima.z[0], deadline)
                continue
        others = None if optima is None else optima.z
        ends = _ends(posterior, best, level, deadline, others)
        if ends.better is None or not movable or attempt + 1 == INTERVAL.optima:
            interval = _interval(best, ends)
            if optima is not None:
                interval, ends = _beside_rivals(interval, ends, optima, least, level)
            return Determined(best, enlarged(covariance, ends), interval)
        best = _polished(best, ends.better, deadline)
    return Determined(best, covariance)


def _without_boxes(best: Hypothesis) -> PiecewiseProblem:
    """Return the problem of a hypothesis with what is known beyond the boxes."""
    return replace(best.problem, prior=best.problem.prior.knowledge)


def _posterior(best: Hypothesis) -> Posterior | PiecewiseProblem:
    """Return the cost without boxes; points of a window without jumps are rolled out together."""
    problem = _without_boxes(best)
    return problem if problem.events else Posterior(problem.objective, problem.prior)


def _other_optima(posterior: Posterior, z: Array, deadline: Deadline) -> Starts:
    """Return optima from starts all over the boxes of the parameters, a few moved at a time."""
    starts = other_starts(z, posterior.objective.unknowns.n_states)
    return levenberg_marquardt(posterior, starts, posterior.nodes, INTERVAL.scan, deadline)


def other_starts(z: Array, states: int) -> Array:
    """Return points (S, d) that differ from z (d,) in one group of parameters each.

    These stand in the middles of parts of their boxes, neighbours of a group in different ones. The
    first unknowns are `states`.
    """
    pinned, parts = np.arange(states, z.size), INTERVAL.parts
    groups = min(pinned.size, INTERVAL.groups)
    starts = np.repeat(z[None], groups * parts, axis=0)
    for i, k in enumerate(pinned.tolist()):
        place, group = divmod(i, groups)
        rows = group * parts + np.arange(parts)
        starts[rows, k] = ((place + np.arange(parts)) % parts + 0.5) / parts
    return starts


def _beside_rivals(
    interval: Interval, ends: Ends, optima: Starts, least: float, level: float
) -> tuple[Interval, Ends]:
    """Return intervals, and what profiles met, with other optima that may be the true one.

    `least` is the cost of the optimum, `level` its growth at the ends.
    """
    growth = np.maximum(optima.squares - least, 0.0)
    rivals = growth <= INTERVAL.rival * level / PROFILE.growth
    z, growth, middle = optima.z[rivals], growth[rivals], interval.middle
    off = z[:, ends.pinned[: middle.size]] - middle
    reach = INTERVAL.far * np.sqrt(growth / level)[:, None]
    above = np.where(off > reach * (interval.upper - middle), off, 0.0)
    below = np.where(-off > reach * (middle - interval.lower), off, 0.0)
    far = ((above > 0.0) | (below < 0.0)).any(axis=1) & (growth > level)
    lower = np.minimum(interval.lower, middle + below[far].min(axis=0, initial=0.0))
    upper = np.maximum(interval.upper, middle + above[far].max(axis=0, initial=0.0))
    visited = np.concatenate([ends.visited, z[far]])
    ends = replace(ends, visited=visited, costs=np.append(ends.costs, growth[far]))
    return replace(interval, lower=lower, upper=upper), ends


def enlarged(covariance: Array, ends: Ends) -> Array:
    """Return a covariance (d, d) of the optimum that allows for all points of the profiles.

    The point that is too far for it by most is allowed for first.
    """
    known = scaled_inverse(covariance)
    off = ends.visited - ends.middle
    grown = np.maximum(ends.costs, INTERVAL.least_growth)
    for _ in range(len(off)):
        distance = ((off @ known) * off).sum(axis=1)
        worst = int(np.argmax(distance / grown))
        if not distance[worst] > grown[worst]:
            break
        along, s, g = known @ off[worst], distance[worst], grown[worst]
        known = known - np.outer(along, along) * (1.0 - g / s) / s
    return scaled_inverse(known)


def _ends(
    posterior: Posterior | PiecewiseProblem,
    best: Hypothesis,
    level: float,
    deadline: Deadline,
    others: Array | None,
) -> Ends:
    unknowns = best.problem.objective.unknowns
    reach = WIDEST * undetermined(unknowns)[unknowns.n_states :]
    probe = best.problem.settings.probe_step
    pinned = best.final_parameters
    return profile_ends(posterior, best.point, pinned, reach, level, probe, deadline, others)


def _interval(best: Hypothesis, ends: Ends) -> Interval:
    """Return the intervals between the ends of profiles; a physical bound may be such an end."""
    problem = best.problem
    lanes = np.arange(ends.pinned.size)
    values, q = ends.points[lanes, ends.pinned], lanes.size // 2
    bounded = _at_physical_bound(problem.objective.unknowns, values)
    told = np.where(ends.closed | bounded, values, np.nan)
    points = np.vstack([best.point[None], ends.points])
    last = np.flatnonzero(problem.objective.grid.measured)[-1]
    states = problem.roll(points)[0][last]
    states = np.where(np.isfinite(states), states, states[:, :1])
    middle = ends.middle[ends.pinned[:q]]
    return Interval(told[:q], middle, told[q:], np.array([states.min(axis=1), states.max(axis=1)]))


def _at_physical_bound(unknowns: Unknowns, values: Array) -> BoolArray:
    """Return which ends (2 q,) of the parameters lie at a bound that the plant cannot leave.

    The lower ends come first. Bounds that the user gives in place of the model's are a guess.
    """
    first, found = unknowns.n_states, np.zeros(values.size, dtype=np.bool_)
    scale, limits = unknowns.scale, unknowns.limits
    for i, (lower, upper) in enumerate(values.reshape(2, -1).T):
        k, variable = first + i, unknowns.model.variables[unknowns.index[first + i]]
        physical = variable.physical
        found[i] = (
            physical in ('both', 'lower')
            and scale.lower[k] == variable.lower
            and lower == limits[0, k]
        )
        found[values.size // 2 + i] = (
            physical in ('both', 'upper')
            and scale.upper[k] == variable.upper
            and upper == limits[1, k]
        )
    return found


def _pull(best: Hypothesis, covariance: Array) -> float:
    """Return the squares that the optimum without boxes gains, by its covariance (d, d)."""
    prior = best.problem.prior
    if prior.boxes is None:
        return 0.0
    pull = prior.boxes @ (best.point - prior.mean)
    gain = pull @ covariance @ pull
    return float(gain) if np.isfinite(gain) else 0.0


def _gradient(best: Hypothesis) -> Array:
    """Return half the gradient (D,) of the cost without boxes."""
    problem, point = _without_boxes(best), best.point
    pull = problem.precision(point) @ (point - problem.mean(point))
    return np.asarray(best.linearisation.jacobian.T @ best.linearisation.residual + pull)


def covariance_without_boxes(best: Hypothesis) -> Array:
    """Return the covariance (D, D) of the point by samples and knowledge, to first order."""
    problem = _without_boxes(best)
    information = best.linearisation.gram + problem.precision(best.point)
    if best.problem.events:
        times = problem.layout.times  # a time lies anywhere in the window
        information[times, times] += 1.0 / BOX_VARIANCE
    return scaled_inverse(information)


def _polished(best: Hypothesis, start: Array, deadline: Deadline) -> Hypothesis:
    """Return the hypothesis at the optimum without boxes near a start (d,)."""
    posterior = _posterior(best)
    found = levenberg_marquardt(posterior, start[None], posterior.nodes, INTERVAL.polish, deadline)
    return hypothesis_at(best.problem, found.z[0], best.earlier)
