"""A window explained: the least squares point of a piecewise problem, and its evidence."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from obs_ros.core.linear_algebra import scaled_inverse
from obs_ros.core.typing import Array
from obs_ros.inference.jumps.piecewise import Layout, Linearisation, PiecewiseProblem
from obs_ros.inference.prior import BOX_VARIANCE

TINY = 1e-200  # guards a division


@dataclass(frozen=True)
class Hypothesis:
    """A window explained: best point (D,) of a layout, with its evidence and information.

    `earlier` holds the places of parameters that jumped between the last window known and this one;
    `covariance` (D, D) is the joint one of the point, in boxes and windows; `cost` the squares of
    residuals, prior and penalties.
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
        """Where what lies in the point."""
        return self.problem.layout

    @cached_property
    def squares(self) -> float:
        """Sum of squared residuals, without those of the prior."""
        return float(self.linearisation.residual @ self.linearisation.residual)

    @cached_property
    def trajectory(self) -> tuple[Array, Array]:
        """States (K, n) and scaled residuals (K, r); NaN = not measured."""
        return self.problem.trajectory(self.point)

    @property
    def jumps(self) -> int:
        """Number of jumps of single parameters."""
        return len(self.earlier) + sum(map(len, self.layout.events))

    @property
    def parameters(self) -> frozenset[int]:
        """Places of the parameters that jumped."""
        return frozenset(self.earlier).union(*self.layout.events)


def hypothesis_at(
    problem: PiecewiseProblem, point: Array, earlier: tuple[int, ...] = ()
) -> Hypothesis:
    """Return the hypothesis that `point` (D,) is the best one of `problem`."""
    linearisation = _linearised(problem, point)
    precision = problem.precision(point)
    off = point - problem.mean(point)
    occam = precision + np.diag(_time_precision(problem.layout))
    information = linearisation.jacobian.T @ linearisation.jacobian + occam
    settings, events = problem.settings, problem.events
    penalty = settings.earlier_penalty(problem.prior.gap) * len(earlier) if earlier else 0.0
    for event in events:
        penalty += settings.jump_penalty + settings.further_penalty * (len(event) - 1)
    gain = np.linalg.slogdet(information)[1] - np.linalg.slogdet(occam)[1]
    cost = float(linearisation.residual @ linearisation.residual + off @ precision @ off) + penalty
    return Hypothesis(
        problem=problem,
        earlier=earlier,
        point=point,
        linearisation=linearisation,
        covariance=scaled_inverse(information),
        cost=cost,
        neg2_log_evidence=cost + float(gain),
    )


def _linearised(problem: PiecewiseProblem, point: Array) -> Linearisation:
    """Return what the window does near a point, by differences as wide as the noise makes sense of.

    At a kink, such as two levels that become equal, a much smaller step would see a slope that no
    window could ever tell; on a chaotic plant a larger one would see no slope at all.
    """
    settings = problem.settings
    steps = np.full(point.size, settings.first_step)
    for _ in range(settings.step_trials):
        linearisation = problem.linearisation(point, steps)
        slopes = np.sqrt((linearisation.jacobian**2).sum(axis=0))
        wanted = np.clip(
            settings.step / np.maximum(slopes, TINY), settings.smallest_step, settings.largest_step
        )
        if (np.maximum(wanted / steps, steps / wanted) < settings.step_ratio).all():
            break
        steps = wanted
    return linearisation


def _time_precision(layout: Layout) -> Array:
    precision = np.zeros(layout.size)
    precision[layout.times] = 1.0 / BOX_VARIANCE
    return precision
