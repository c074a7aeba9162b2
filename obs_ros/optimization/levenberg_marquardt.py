"""Bounded Levenberg-Marquardt from many starts at once, on batched finite differences.

Marquardt scaling, Nielsen's damping update (Madsen, Nielsen & Tingleff 2004), bounds by freezing
what leans outward and clipping the step. A trial point and its Jacobian are one rollout.
"""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from obs_ros.core.deadline import Deadline
from obs_ros.core.typing import AnyArray, Array, BoolArray
from obs_ros.optimization.lm_linalg import NOTHING, damped_steps, judged
from obs_ros.optimization.problem import Linearised

DAMPING = 1e-2
MAX_DAMPING = 1e10
MAX_REJECTIONS = 8
FIRST_STEP = 1e-8
# Difference steps follow the noise: a fixed one loses a third of chaotic plants.
STEP_SHARE, MIN_STEP, MAX_STEP = 0.02, 1e-11, 1e-6
# Converged when a full Gauss-Newton step would gain less than this share of d * noise variance.
GAIN_SHARE, STALLED_SHARE = 0.01, 1e-9
# Rollouts in which a start must gain that much: at a kink full steps promise for ever.
PATIENCE = 40


@dataclass(frozen=True)
class Starts:
    """Points z (P, d) with their squares (P,), best first, and whether each converged (P,)."""

    z: Array
    squares: Array
    converged: BoolArray


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
) -> Starts:
    """Minimise the squares over the first `nodes` nodes from every start z (P, d).

    Each start ends at least as good as it began. It stops when it has converged, stalled or
    diverged; all stop after `iterations` rollouts, at the deadline, when those that have converged
    so far are `enough`, or when the least squares so far, told at every rollout, are `hopeless`.
    """
    d = z.shape[1]
    freedom = max(1, objective.count(nodes) - d)
    least = objective.floor(nodes)
    limits = objective.limits
    batch = _Batch.of(z, *objective.linearise(z, np.full_like(z, FIRST_STEP), nodes))
    begun = usable(batch.squares, batch.hessian)
    stopped = [batch.take(~begun)]
    batch = batch.take(begun)
    best = np.inf  # squares of the best converged start
    for iteration in range(iterations):
        if not batch.squares.size or deadline.passed:
            break
        lowest = min(best, float(batch.squares.min()))
        if hopeless is not None and hopeless(lowest):
            break
        variance = max(least, lowest) / freedom
        step, gain, full_gain = damped_steps(
            batch.z, batch.gradient, batch.hessian, batch.damping, limits
        )
        batch.converged = full_gain < GAIN_SHARE * d * variance
        trial = batch.z + step
        inside = ((trial > limits[0]) & (trial < limits[1])).all(axis=1)
        over = (
            batch.converged
            | (inside & (gain <= STALLED_SHARE * d * variance))
            | (batch.rejections >= MAX_REJECTIONS)
            | (batch.damping >= MAX_DAMPING)
        )
        if iteration % PATIENCE == 0:
            over |= batch.mark - batch.squares < GAIN_SHARE * d * variance
            batch.mark = batch.squares.copy()
        if over.any():
            stopped.append(batch.take(over))
            best = np.min(batch.squares, initial=best, where=batch.converged)
            if enough is not None and enough(_sorted(stopped)):
                break
            batch, trial, gain = batch.take(~over), trial[~over], gain[~over]
            if not batch.squares.size:
                break
        h = STEP_SHARE * np.sqrt(variance / np.maximum(batch.curvature, NOTHING))
        h = np.minimum(np.maximum(h, MIN_STEP), MAX_STEP)
        batch.move(trial, gain, *objective.linearise(trial, h, nodes))
    return _sorted([*stopped, batch])


@dataclass
class _Batch:
    """Starts under way: z (P, d), squares (P,), J'r (P, d), J'J (P, d, d) and damping (P,)."""

    z: Array
    squares: Array
    gradient: Array
    hessian: Array
    damping: Array
    growth: Array
    rejections: AnyArray
    converged: BoolArray
    mark: Array  # squares (P,) some rollouts ago

    @classmethod
    def of(cls, z: Array, squares: Array, gradient: Array, hessian: Array) -> '_Batch':
        return cls(
            z=z,
            squares=squares,
            gradient=gradient,
            hessian=hessian,
            damping=np.full(len(z), DAMPING),
            growth=np.full(len(z), 2.0),
            rejections=np.zeros(len(z), dtype=np.int64),
            converged=np.zeros(len(z), dtype=bool),
            mark=np.full(len(z), np.inf),
        )

    @property
    def curvature(self) -> Array:
        """Diagonals (P, d) of J'J."""
        return np.diagonal(self.hessian, axis1=1, axis2=2)

    def take(self, chosen: BoolArray) -> '_Batch':
        """Return the chosen starts."""
        # Field by field: fields() would take longer than the linear algebra of small windows.
        return _Batch(
            self.z[chosen],
            self.squares[chosen],
            self.gradient[chosen],
            self.hessian[chosen],
            self.damping[chosen],
            self.growth[chosen],
            self.rejections[chosen],
            self.converged[chosen],
            self.mark[chosen],
        )

    def move(
        self, trial: Array, gain: Array, squares: Array, gradient: Array, hessian: Array
    ) -> None:
        """Go to the trial points that cost less, and adapt the damping to the predicted gains."""
        squares = np.where(usable(squares, hessian), squares, np.inf)
        won = judged(self.squares, squares, gain, self.damping, self.growth, self.rejections)
        if won.all():
            self.z, self.squares, self.gradient, self.hessian = trial, squares, gradient, hessian
        else:
            for mine, theirs in (
                (self.z, trial),
                (self.squares, squares),
                (self.gradient, gradient),
                (self.hessian, hessian),
            ):
                mine[won] = theirs[won]


def usable(squares: Array, hessian: Array) -> BoolArray:
    """Return whether residuals and derivatives are finite (P,)."""
    return np.asarray(np.isfinite(squares) & np.isfinite(hessian).all(axis=(1, 2)))


def _sorted(batches: list[_Batch]) -> Starts:
    z, squares, converged = (
        np.concatenate([getattr(batch, name) for batch in batches])
        for name in ('z', 'squares', 'converged')
    )
    order = np.argsort(np.where(np.isfinite(squares), squares, np.inf), kind='stable')
    return Starts(z[order], squares[order], converged[order])
