"""Hypotheses about a window: the least squares point of a piecewise problem, and its evidence.

The marginal likelihood of the samples y under a hypothesis H with parameters z is approximated by
Laplace's method (MacKay 1992, Neural Computation 4, 415-447; 2003, chapter 28). With residuals r in
units of the noise, Jacobian J and a normal prior of mean m and precision P, at the optimum z

    -2 log p(y, H) = r'r + (z - m)' P (z - m) + log det(J'J + P) - log det P - 2 log odds(H) + const

in which the constant is the same for all hypotheses of a window. The least is the most probable.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from obs_ros.core.linear_algebra import (
    inverse_and_log_determinant,
    log_determinant,
    scaled_inverse,
)
from obs_ros.core.residual_tests import inflation_by
from obs_ros.core.typing import Array, IntArray
from obs_ros.inference.jumps.layout import Layout
from obs_ros.inference.jumps.linearisation import Linearisation
from obs_ros.inference.jumps.piecewise import PiecewiseProblem
from obs_ros.inference.parameterisation import BOX_VARIANCE
from obs_ros.optimization.lm_linalg import TINY


@dataclass(frozen=True)
class Hypothesis:
    """Optimum `point` (D,) of a piecewise problem, with its evidence and information.

    `earlier` holds the places of parameters that jumped between the last window known and this one;
    `covariance` (D, D) is the joint one of the point, in boxes and windows; `cost` is the sum of
    squares of residuals and prior and of the penalties, -2 log prior odds.
    """

    problem: PiecewiseProblem
    earlier: tuple[int, ...]
    point: Array
    linearisation: Linearisation
    covariance: Array
    cost: float
    neg2_log_evidence: float

    @property
    def layout(self) -> Layout:
        """Layout of the point."""
        return self.problem.layout

    @property
    def final(self) -> IntArray:
        """Places (d,) of the initial states, and of the parameters at the end of the window."""
        return self.layout.final(self.point)

    @property
    def final_parameters(self) -> IntArray:
        """Places (q,) of the parameters at the end of the window."""
        return self.final[self.problem.objective.unknowns.n_states :]

    @cached_property
    def squares(self) -> float:
        """Sum of squared residuals, without those of the prior."""
        return float(self.linearisation.residual @ self.linearisation.residual)

    @cached_property
    def trajectory(self) -> tuple[Array, Array]:
        """States (K, n) and scaled residuals (K, r); NaN where nothing contradicts the point."""
        states, outputs = self.linearisation.path
        return states, self.problem.objective.grid.residuals(outputs)

    @cached_property
    def judged(self) -> dict[Any, Any]:
        """Judgements on it that are asked for more than once, by what they are about."""
        return {}

    @property
    def residuals(self) -> Array:
        """Scaled residuals (K, r), without a rollout; NaN where nothing contradicts the point."""
        grid = self.problem.objective.grid
        measured = grid.weight > 0.0
        residuals = np.full(measured.shape, np.nan)
        residuals[measured] = self.linearisation.residual
        if grid.ends is not None:
            residuals[grid.ends.saturated & (residuals == 0.0)] = np.nan
        return residuals

    @property
    def unseen(self) -> float:
        """Time (windows) before this window in which its earlier jumps went unseen."""
        return _unseen(self.problem, self.point, self.covariance, self.earlier)

    @property
    def jumps(self) -> int:
        """Number of jumps of single parameters."""
        return len(self.earlier) + sum(map(len, self.problem.events))

    @property
    def parameters(self) -> frozenset[int]:
        """Places of the parameters that jumped."""
        return frozenset(self.earlier).union(*self.problem.events)


def hypothesis_at(
    problem: PiecewiseProblem,
    point: Array,
    earlier: tuple[int, ...] = (),
    curvature: Array | None = None,
) -> Hypothesis:
    """Return the hypothesis whose optimum is `point` (D,), by Laplace's approximation there.

    The `curvature` (D,) of the squares, if it is known, tells steps that suit.
    """
    linearisation = _linearised(problem, point, curvature)
    precision = problem.precision(point)
    off = point - problem.mean(point)
    # A time lies anywhere in the window: as a normal prior, that is about the time found.
    known, before = precision, problem.prior.log_determinant
    if problem.events:
        known = precision.copy()
        known[problem.layout.times, problem.layout.times] += 1.0 / BOX_VARIANCE
        before = log_determinant(known)
    covariance, after = inverse_and_log_determinant(linearisation.gram + known)
    narrowing = after - before
    squares = linearisation.residual @ linearisation.residual + off @ precision @ off
    cost = float(squares) + _penalty(problem)
    if earlier:
        unseen = _unseen(problem, point, covariance, earlier)
        cost += problem.settings.earlier_penalty(unseen) * len(earlier)
    return Hypothesis(
        problem=problem,
        earlier=earlier,
        point=point,
        linearisation=linearisation,
        covariance=covariance,
        cost=cost,
        neg2_log_evidence=cost + narrowing,
    )


def discounted(hypothesis: Hypothesis, inflation: float) -> float:
    """Return -2 log evidence with squares that count for less, by the `inflation` of variances.

    A correlated residual holds fewer independent values than it has samples.
    """
    return hypothesis.neg2_log_evidence - hypothesis.squares * (1.0 - 1.0 / inflation)


def beats(rival: Hypothesis, best: Hypothesis, correlation: float) -> bool:
    """Whether a hypothesis with more jumps is to be believed rather than the best so far.

    Squares gained must exceed all that the evidence charges for them. Where the rival's residual is
    more correlated than the noise, of lag-1 `correlation`, squares count for less: a jump must not
    stand for dynamics that the model lacks. Cost must fall too, as at the kinks of a model the
    determinants mean little.
    """
    if rival.neg2_log_evidence >= best.neg2_log_evidence or rival.cost > best.cost:
        return False
    inflation = inflation_by(rival.trajectory[1], correlation)
    return discounted(rival, inflation) < discounted(best, inflation)


def _unseen(
    problem: PiecewiseProblem, point: Array, covariance: Array, earlier: tuple[int, ...]
) -> float:
    """Return the time (windows) before a window in which jumps of some parameters went unseen.

    The window before would have shown them as well as this one does.
    """
    places, prior = list(earlier), problem.prior
    if not places:
        return 0.0
    size = point[places] - prior.mean[places]
    visible = float(size @ scaled_inverse(covariance[np.ix_(places, places)]) @ size)
    return problem.settings.unseen(prior.gap or 0.0, visible)


def _penalty(problem: PiecewiseProblem) -> float:
    """Return -2 log of the prior odds of the jumps inside a window against none."""
    settings, penalty = problem.settings, 0.0
    for event in problem.events:
        penalty += settings.jump_penalty + settings.further_penalty * (len(event) - 1)
    return penalty


def _linearised(problem: PiecewiseProblem, point: Array, curvature: Array | None) -> Linearisation:
    """Return the linearisation at a point (D,), by differences that suit the noise.

    At a kink, such as two levels that become equal, a much smaller step would see a slope that no
    window could ever tell; on a chaotic plant a larger one would see no slope at all.
    """
    settings = problem.settings
    steps = np.full(point.size, settings.first_step)
    if curvature is not None and np.isfinite(curvature).all():
        steps = settings.noise_step / np.sqrt(np.maximum(curvature, TINY))
        steps = np.clip(steps, settings.smallest_step, settings.largest_step)
    for _ in range(settings.step_trials):
        linearisation = problem.linearisation(point, steps)
        slopes = np.sqrt(np.diagonal(linearisation.gram))
        wanted = settings.noise_step / np.maximum(slopes, TINY)
        wanted = np.clip(wanted, settings.smallest_step, settings.largest_step)
        if (np.maximum(wanted / steps, steps / wanted) < settings.step_ratio).all():
            break
        steps = wanted
    return linearisation
