"""Covariances of windows that are far from linear, from the profile of their squares.

Two standard deviations off along one unknown, the others moving along, squares should have grown by
4. Where they do not, the valley is bent, and may be much longer than it seems from its bottom: then
the others are optimised at that distance, and what squares have really grown by tells the width.
"""

import numpy as np

from obs_ros.core.typing import Array
from obs_ros.inference.jumps.hypothesis import Hypothesis
from obs_ros.inference.prior import Posterior
from obs_ros.optimization.lm_linalg import NOTHING, solved

OFF = 2.0  # standard deviations
BENT = 2.0  # times more, or less, than the squares should have grown
ITERATIONS = 6
DAMPING = 1e-6
MOST_WIDENING = 5.0
MARGIN = 1.25  # of a deviation, as a bent valley has longer tails than a straight one


def widened_by_profile(best: Hypothesis) -> tuple[Array, bool]:
    """Return the covariance (d, d) of a hypothesis without a jump, and whether its window is bent.

    It is wider where the window is bent, never narrower.
    """
    posterior, z = Posterior(best.problem.objective, best.problem.prior), best.point
    deviations = np.sqrt(np.diagonal(best.covariance))
    along = best.covariance / deviations  # column k: one standard deviation of unknown k
    points = z + OFF * np.vstack([along.T, -along.T])
    pinned = np.tile(np.arange(z.size), 2)
    inside = ((points >= posterior.limits[0]) & (points <= posterior.limits[1])).all(axis=1)
    points, pinned = points[inside], pinned[inside]
    if not pinned.size:
        return best.covariance, False
    lowest = float(posterior.costs(z[None])[0])
    growth = (posterior.costs(points) - lowest) / OFF**2
    if growth.max() < BENT and growth.min() > 1.0 / BENT:
        return best.covariance, False
    probe = best.problem.settings.probe_step
    growth = (_optimised(posterior, points, pinned, probe) - lowest) / OFF**2
    factors = np.full(z.size, MARGIN)
    widths = 1.0 / np.sqrt(np.maximum(growth, MOST_WIDENING**-2))
    np.maximum.at(factors, pinned, MARGIN * widths)
    return np.asarray(best.covariance * np.outer(factors, factors)), True


def _optimised(posterior: Posterior, points: Array, pinned: Array, probe: float) -> Array:
    """Return the least squares (P,) around points (P, d) of which one unknown each is held.

    `probe` is the step (box) of differences.
    """
    points = points.copy()
    squares = np.full(len(points), np.inf)
    steps = np.zeros_like(points)
    for _ in range(ITERATIONS):
        found, gradients, hessians = posterior.linearise(
            points, np.full_like(points, probe), posterior.nodes
        )
        better = found < squares
        squares = np.where(better, found, squares)
        for k, hold in enumerate(pinned):
            if not better[k]:  # too far: half the step back
                steps[k] *= 0.5
                points[k] -= steps[k]
                continue
            free = np.ones(points.shape[1], dtype=np.bool_)
            free[hold] = False
            scale = np.diagonal(hessians[k]) + NOTHING
            step = solved(hessians[k], scale, DAMPING, -gradients[k], free)
            steps[k] = np.clip(points[k] + step, *posterior.limits) - points[k]
            points[k] += steps[k]
    return squares
