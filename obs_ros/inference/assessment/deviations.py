"""Standard deviations and intervals of an estimate's values, of the covariance of its unknowns."""

from dataclasses import dataclass, replace

import numpy as np

from obs_ros.core.estimate import QUANTILE
from obs_ros.core.linear_algebra import eigen
from obs_ros.core.model import Model
from obs_ros.core.typing import Array, BoolArray
from obs_ros.inference.assessment.identifiability import undetermined, undetermined_states
from obs_ros.inference.assessment.interval import Interval
from obs_ros.inference.assessment.uncertainty import AtEnd, Uncertainty
from obs_ros.inference.jumps.hypothesis import Hypothesis
from obs_ros.inference.parameterisation import Unknowns
from obs_ros.optimization.lm_linalg import TINY


@dataclass(frozen=True)
class Deviations:
    """Standard deviations in the variables' units; NaN where one would mean nothing.

    Of the initial state (n,), the state at the end (n,) and the parameters there (q,). `lower` and
    `upper` (n + q,) are the ends of the two-sided 95 % intervals of the last two, `joint` (n + q,
    n + q) is their covariance, (0, 0) where all is withheld.
    """

    initial: Array
    state: Array
    parameters: Array
    lower: Array
    upper: Array
    joint: Array

    def beside(self, hypothesis: Hypothesis, excess: Array) -> 'Deviations':
        """Return those of the mixture of a hypothesis and others that explain as much.

        `excess` (n + q, n + q) is the second moment in excess of the hypothesis's own covariance,
        see `Uncertainty`. Rivals that are surer than the hypothesis do not make it surer: where the
        excess is negative it counts as none. What is no longer determined by then is withheld.
        """
        unknowns, n = hypothesis.problem.objective.unknowns, self.state.size
        rows = _in_units(hypothesis)
        extra = _positive_part(rows @ excess @ rows.T, np.diagonal(self.joint))
        limit = np.full(n + self.parameters.size, np.inf)
        limit[:n] = undetermined_states(unknowns)
        limit[unknowns.index[unknowns.n_states :]] = (
            undetermined(unknowns)[unknowns.n_states :] * rows.max(axis=0)[n:]
        )
        own = np.append(self.state, self.parameters)
        sd = np.sqrt(np.maximum(own**2 + np.diagonal(extra), 0.0))
        longer = np.where(own > 0.0, sd / np.where(own > 0.0, own, 1.0), 1.0)
        z = hypothesis.point[hypothesis.final]
        middle = np.append(hypothesis.linearisation.state, unknowns.given[n:])
        places = unknowns.index[unknowns.n_states :]
        middle[places] = unknowns.scale.values(z)[unknowns.n_states :]
        sides = middle + longer * (np.array([self.lower, self.upper]) - middle)
        sides[:, n:] = _inside_bounds(unknowns, sides[:, n:])
        return replace(
            self,
            state=np.where(sd <= limit, sd, np.nan)[:n],
            parameters=np.where(sd <= limit, sd, np.nan)[n:],
            lower=sides[0],
            upper=sides[1],
            joint=self.joint + extra,
        )

    @classmethod
    def withheld(cls, model: Model) -> 'Deviations':
        """Return none."""
        n, q = len(model.states), len(model.parameters)
        nothing = np.full(n + q, np.nan)
        return cls(
            nothing[:n].copy(), nothing[:n].copy(), nothing[n:].copy(),
            nothing.copy(), nothing.copy(), np.empty((0, 0)),
        )  # fmt: skip

    @property
    def without_state(self) -> 'Deviations':
        """Those of the parameters alone."""
        return replace(self, state=np.full_like(self.state, np.nan), joint=np.empty((0, 0)))

    def interval(self, i: int) -> tuple[float, float]:
        """Return the interval of the i-th of states and parameters, NaN without a deviation."""
        n = self.state.size
        if np.isnan(self.state[i] if i < n else self.parameters[i - n]):
            return np.nan, np.nan
        return float(self.lower[i]), float(self.upper[i])

    @classmethod
    def of(
        cls,
        hypothesis: Hypothesis,
        covariance: Array,
        inflation: float,
        end: AtEnd | None = None,
        interval: Interval | None = None,
    ) -> 'Deviations':
        """Return those of a hypothesis with this joint covariance (D, D) times `inflation`.

        `end` is what process noise makes of the end; `interval` holds the parameters' where the
        covariance does not.

        What is not estimated has none, 0. Above a tenth of its box, or on a log scale 30 % of its
        value, a standard deviation says that the value is not determined, and is withheld; so is
        that of an interval of four tenths.
        """
        unknowns = hypothesis.problem.objective.unknowns
        n, limit = len(unknowns.model.states), undetermined(unknowns)
        # Along a bent valley the states follow the profiles; the rest is what the boxes leave.
        straight = covariance if interval is None else hypothesis.covariance
        joint = inflation * joint_covariance(hypothesis, straight, end)
        if end is not None:
            joint += inflation * end.covariance
        values, sides, known = _parameters(hypothesis, inflation * covariance, interval)
        if end is not None and end.parameters is not None:
            values = end.parameters
            walked = walked_deviations(unknowns, values, joint)
            sides, known = values + QUANTILE * np.array([-walked, walked]), np.isfinite(walked)
            sides = _inside_bounds(unknowns, sides)
        spread = np.sqrt(np.maximum(np.diagonal(joint), 0.0))
        middle = np.append(hypothesis.linearisation.state, values)
        lower, upper = middle - QUANTILE * spread, middle + QUANTILE * spread
        lower[n:], upper[n:] = sides
        if interval is not None:
            pushed = 0.0 if end is None else np.diagonal(end.covariance)[:n]
            for side, reached in ((lower, interval.states[0]), (upper, interval.states[1])):
                off = reached - middle[:n]
                off = np.sign(off) * np.sqrt(off**2 + QUANTILE**2 * inflation * pushed)
                further = np.abs(off) > np.abs(side[:n] - middle[:n])
                side[:n] = np.where(further, middle[:n] + off, side[:n])
        sd = np.maximum(upper - middle, middle - lower) / QUANTILE
        sd[n:] = np.where(known, sd[n:], np.nan)
        own = np.sqrt(np.maximum(np.diagonal(inflation * straight)[: unknowns.dimension], 0.0))
        slopes = unknowns.scale.slopes(hypothesis.point[: unknowns.dimension])
        initial = np.zeros(len(middle))
        initial[unknowns.index] = np.where(own <= limit, own * slopes, np.nan)
        told = np.where((sd > 0.0) & (spread > 0.0), sd / np.maximum(spread, TINY), 1.0)
        return cls(
            initial=initial[:n],
            state=np.where(sd[:n] <= undetermined_states(unknowns), sd[:n], np.nan),
            parameters=sd[n:],
            lower=lower,
            upper=upper,
            joint=joint * np.outer(told, told),
        )


def _parameters(
    hypothesis: Hypothesis, covariance: Array, interval: Interval | None
) -> tuple[Array, Array, BoolArray]:
    """Return the parameters (q,) at the end, their intervals (2, q), and which are determined (q,).

    In their units; those that are not estimated have intervals of no length. Parameters are those
    in the middle of an interval that profiles tell.
    """
    unknowns = hypothesis.problem.objective.unknowns
    n, first, limit = len(unknowns.model.states), unknowns.n_states, undetermined(unknowns)
    final = hypothesis.final
    z = hypothesis.point[final].copy()
    boxes = np.sqrt(np.maximum(np.diagonal(covariance)[final], 0.0))
    ends, known = z + QUANTILE * np.array([-boxes, boxes]), boxes <= limit
    if interval is not None:
        ends[:, first:], z[first:] = (interval.lower, interval.upper), interval.middle
        known[first:] = interval.told(unknowns)
    values, sides = unknowns.given[n:].copy(), np.tile(unknowns.given[n:], (2, 1))
    places, told = unknowns.index[first:] - n, np.ones(len(values), dtype=np.bool_)
    values[places] = unknowns.scale.values(z)[first:]
    sides[:, places] = unknowns.scale.values(np.clip(ends, *unknowns.limits))[:, first:]
    told[places] = known[first:]
    return values, sides, told


def _inside_bounds(unknowns: Unknowns, sides: Array) -> Array:
    """Return ends of intervals (2, q) of the parameters, none beyond a bound."""
    n, first = len(unknowns.model.states), unknowns.n_states
    places = unknowns.index[first:] - n
    bounded = np.isfinite(unknowns.limits[:, first:])
    lower = np.where(bounded[0], unknowns.scale.lower[first:], -np.inf)
    upper = np.where(bounded[1], unknowns.scale.upper[first:], np.inf)
    found = sides.copy()
    found[:, places] = np.clip(sides[:, places], lower, upper)
    return found


def parameters_at_end(uncertainty: Uncertainty) -> tuple[Array, Array, bool]:
    """Return mean (q,) and covariance (q, q) of the estimated parameters at the end, in boxes.

    And whether they have walked there: else they are means over the window, but for jumps.
    """
    best, end = uncertainty.hypothesis, uncertainty.end
    unknowns = best.problem.objective.unknowns
    n, states = len(unknowns.model.states), unknowns.n_states
    final = best.final_parameters
    if end is None or end.parameters is None:
        return best.point[final], uncertainty.covariance[np.ix_(final, final)], False
    places = unknowns.index[states:]
    joint = joint_covariance(best, uncertainty.covariance, end) + end.covariance
    z = np.full(unknowns.dimension, 0.5)
    z[states:] = unknowns.scale.places_of(end.parameters[places - n], states)
    slopes = unknowns.scale.slopes(z)[states:]
    return z[states:], joint[np.ix_(places, places)] / np.outer(slopes, slopes), True


def walked_deviations(unknowns: Unknowns, parameters: Array, joint: Array) -> Array:
    """Return the deviations (q,) of parameters that walk; NaN where they are not determined.

    parameters (q,) are those at the end, joint (n + q, n + q) their covariance with the state's.
    """
    n, states = len(unknowns.model.states), unknowns.n_states
    places = unknowns.index[states:]
    deviations = np.sqrt(np.maximum(np.diagonal(joint)[n:], 0.0))
    z = np.full(unknowns.dimension, 0.5)
    z[states:] = unknowns.scale.places_of(parameters[places - n], states)
    limit = undetermined(unknowns)[states:] * unknowns.scale.slopes(z)[states:]
    own = deviations[places - n]
    deviations[places - n] = np.where(own <= limit, own, np.nan)
    return np.asarray(deviations)


def _positive_part(matrix: Array, variances: Array) -> Array:
    """Return a symmetric matrix (D, D), in units of variances (D,), without what is negative."""
    scale = np.sqrt(np.maximum(variances, TINY))
    values, vectors = eigen(matrix / np.outer(scale, scale))
    vectors = vectors * scale[:, None]
    return np.asarray((vectors * np.maximum(values, 0.0)) @ vectors.T)


def _in_units(hypothesis: Hypothesis) -> Array:
    """Return the derivatives of end state and parameters by these, the estimated ones in boxes."""
    unknowns = hypothesis.problem.objective.unknowns
    n, states = len(unknowns.model.states), unknowns.n_states
    final = hypothesis.final
    slopes = unknowns.scale.slopes(hypothesis.point[final])[states:]
    rows = np.zeros((len(unknowns.model.variables), n + slopes.size))
    rows[np.arange(n), np.arange(n)] = 1.0
    rows[unknowns.index[states:], n + np.arange(slopes.size)] = slopes
    return rows


def joint_covariance(hypothesis: Hypothesis, covariance: Array, end: AtEnd | None = None) -> Array:
    """Return the covariance (n + q, n + q) of end state and parameters by that (D, D) of the point.

    In the variables' units, to first order; 0 for parameters that are not estimated.
    """
    unknowns = hypothesis.problem.objective.unknowns
    final = hypothesis.final_parameters
    slopes = unknowns.scale.slopes(hypothesis.point[hypothesis.final])
    rows = np.zeros((len(unknowns.model.variables), len(covariance)))
    rows[: len(unknowns.model.states)] = hypothesis.linearisation.state_jacobian
    rows[unknowns.index[unknowns.n_states :], final] = slopes[unknowns.n_states :]
    if end is not None and end.jacobian is not None:
        rows[len(unknowns.model.states) :, : hypothesis.layout.dimension] = end.jacobian
    joint = rows @ covariance @ rows.T
    return np.asarray(0.5 * (joint + joint.T))
