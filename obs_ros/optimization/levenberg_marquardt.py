"""Bounded Levenberg-Marquardt from many starts at once, on batched finite differences.

Least squares F(z) = |r(z)|^2 within limits: each step solves (J'J + mu D) s = -J'r, with D the
diagonal of J'J (Marquardt 1963) and mu by Nielsen's rule (Madsen, Nielsen & Tingleff 2004, section
3.2). An unknown at a limit whose gradient leans outward is frozen; a step is clipped to the limits.
A trial point and its Jacobian are one rollout.
"""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from obs_ros.core.deadline import Deadline
from obs_ros.core.typing import AnyArray, Array, BoolArray
from obs_ros.optimization.lm_linalg import moved, proposed
from obs_ros.optimization.problem import Linearised, Problem


@dataclass(frozen=True)
class LMSettings:
    """Settings of Levenberg-Marquardt.

    Steps of z are in boxes; gains are shares of d times the noise variance, by which a fit's
    squares scatter.
    """

    damping: float = 1e-2  # mu at the start, against the curvature
    most_damping: float = 1e10  # a start that needs more has stalled
    most_rejections: int = 8  # trials in a row, after which a start has stalled
    least_curvature: float = 1e-6  # of an unknown in D, against the largest
    fastest_shrink: float = 1.0 / 3.0  # of mu at one step (Nielsen)
    first_step: float = 1e-8  # of the differences, as long as the noise is not known
    # Later steps follow the noise: a fixed one loses a third of chaotic plants.
    step_share: float = 0.02  # of an unknown's deviation with all others known
    least_step: float = 1e-11  # rounding
    most_step: float = 1e-6  # curvature
    converged_gain: float = 0.01  # of a full Gauss-Newton step: less is not worth a rollout
    stalled_gain: float = 1e-9  # of a damped step
    patience: int = 40  # rollouts for a gain of `converged_gain`: a kink promises one for ever
    same_optimum: float = 0.1025  # apart at most are squares of one optimum: 0.41 for d = 4

    @cached_property
    def rules(self) -> Array:
        """The numbers (8,) that compiled loops take, in the order in which these use them."""
        return np.array([
            self.least_curvature, self.converged_gain, self.stalled_gain, self.most_damping,
            self.most_rejections, self.step_share, self.least_step, self.most_step,
        ])  # fmt: skip


LM_DEFAULTS = LMSettings()


@dataclass(frozen=True)
class Starts:
    """Points z (P, d) with their squares (P,), best first, and whether each converged (P,)."""

    z: Array
    squares: Array
    converged: BoolArray

    def agreeing(self, best: float, width: float) -> int:
        """Count the converged starts whose squares are at most `width` above the best."""
        return int(np.count_nonzero(self.converged & (self.squares - best <= width)))


class Trail:
    """The least squares of the latest rollouts."""

    def __init__(self, rollouts: int) -> None:
        self._squares: deque[float] = deque(maxlen=rollouts)

    def gain(self, squares: float) -> float:
        """Return by how much they have fallen to `squares`; infinity as long as they are few."""
        full = len(self._squares) == self._squares.maxlen
        before = self._squares[0] if full else np.inf
        self._squares.append(squares)
        return before - squares


def levenberg_marquardt(
    objective: Linearised,
    z: Array,
    nodes: int,
    iterations: int,
    deadline: Deadline,
    enough: Callable[[Starts], bool] | None = None,
    hopeless: Callable[[float], bool] | None = None,
    settings: LMSettings = LM_DEFAULTS,
) -> Starts:
    """Minimise the squares over the first `nodes` nodes from every start z (P, d).

    Each start ends at least as good as it began. It stops when it has converged, stalled or
    diverged; all stop after `iterations` rollouts, at the deadline, when those that have converged
    so far are `enough`, or when the least squares so far, given at every rollout, are `hopeless`.
    """
    freedom = max(1, objective.count(nodes) - z.shape[1])
    least = objective.floor(nodes)
    batch = _Batch.of(
        z, *objective.linearise(z, np.full_like(z, settings.first_step), nodes), settings
    )
    begun = np.isfinite(batch.squares) & np.isfinite(batch.hessian).all(axis=(1, 2))
    stopped = []
    if not begun.all():
        stopped.append(batch.take(~begun))
        batch = batch.take(begun)
    best = np.inf  # squares of the best converged start
    for iteration in range(iterations):
        if not batch.squares.size or deadline.passed:
            break
        lowest = min(best, float(batch.squares.min()))
        if hopeless is not None and hopeless(lowest):
            break
        variance = max(least, lowest) / freedom
        trial, gain, h, over, number = batch.propose(objective.limits, variance, iteration)
        if number:
            stopped.append(batch.take(over))
            best = np.min(batch.squares, initial=best, where=batch.converged)
            if enough is not None and enough(_sorted(stopped)):
                break
            if number == over.size:
                batch = batch.take(~over)
                break
            batch, trial, gain, h = batch.take(~over), trial[~over], gain[~over], h[~over]
        batch.move(trial, gain, *objective.linearise(trial, h, nodes))
    return _sorted([*stopped, batch])


def optimum_width(problem: Problem, squares: float, settings: LMSettings = LM_DEFAULTS) -> float:
    """Return how far apart the squares of fits of one optimum may be, next to a fit's `squares`."""
    nodes, d = problem.nodes, problem.dimension
    variance = max(squares, problem.floor(nodes)) / max(1, problem.count(nodes) - d)
    return settings.same_optimum * d * variance


@dataclass
class _Batch:
    """Starts under way."""

    settings: LMSettings
    z: Array  # (P, d)
    squares: Array  # (P,)
    gradient: Array  # (P, d) J'r
    hessian: Array  # (P, d, d) J'J
    damping: Array  # (P,) mu
    growth: Array  # (P,) factor of mu at the next rejection
    rejections: AnyArray  # (P,) in a row
    converged: BoolArray  # (P,)
    mark: Array  # (P,) squares some rollouts ago

    @classmethod
    def of(
        cls, z: Array, squares: Array, gradient: Array, hessian: Array, settings: LMSettings
    ) -> '_Batch':
        count = len(z)
        return cls(
            settings, z.copy(), squares, gradient, hessian, np.full(count, settings.damping),
            np.full(count, 2.0), np.zeros(count, dtype=np.int64), np.zeros(count, dtype=bool),
            np.full(count, np.inf),
        )  # fmt: skip

    def propose(
        self, limits: Array, variance: float, iteration: int
    ) -> tuple[Array, Array, Array, BoolArray, int]:
        """Return trial points (P, d), predicted gains (P,), steps (P, d), and which are over (P,).

        The steps are those of differences at the trial points; last comes how many are over. See
        `proposed`.
        """
        trial, gain, h, self.converged, over, number = proposed(
            self.z, self.squares, self.gradient, self.hessian, self.damping, self.rejections,
            self.mark, limits, variance, iteration % self.settings.patience == 0,
            self.settings.rules,
        )  # fmt: skip
        return trial, gain, h, over, number

    def take(self, chosen: BoolArray) -> '_Batch':
        """Return the chosen starts."""
        # Field by field: fields() would take longer than the linear algebra of small windows.
        return _Batch(
            self.settings, self.z[chosen], self.squares[chosen], self.gradient[chosen],
            self.hessian[chosen], self.damping[chosen], self.growth[chosen],
            self.rejections[chosen], self.converged[chosen], self.mark[chosen],
        )  # fmt: skip

    def move(
        self, trial: Array, gain: Array, squares: Array, gradient: Array, hessian: Array
    ) -> None:
        """Go to the trial points that cost less, and adapt the damping to the predicted gains."""
        moved(
            self.z, self.squares, self.gradient, self.hessian, self.damping, self.rejections,
            self.growth, trial, gain, squares, gradient, hessian, self.settings.fastest_shrink,
        )  # fmt: skip


def _sorted(batches: list[_Batch]) -> Starts:
    batches = [batch for batch in batches if batch.squares.size] or batches[-1:]
    if len(batches) == 1 and batches[0].squares.size == 1:
        only = batches[0]
        return Starts(only.z, only.squares, only.converged)
    z, squares, converged = (
        np.concatenate([getattr(batch, name) for batch in batches])
        for name in ('z', 'squares', 'converged')
    )
    order = np.argsort(np.where(np.isfinite(squares), squares, np.inf), kind='stable')
    return Starts(z[order], squares[order], converged[order])
