"""Covariances of windows that are far from linear, from the profile of their squares.

Two standard deviations off along one unknown, the others moving along, squares should have grown by
4. Where they do not, the valley is bent, and may be much longer than it seems from its bottom: then
the others are optimised at that distance (profile likelihood; Raue et al. 2009), and the growth of
the squares gives the width.
"""

from dataclasses import dataclass

import numpy as np

from obs_ros.core.typing import Array
from obs_ros.inference.jumps.hypothesis import Hypothesis
from obs_ros.inference.prior import Posterior
from obs_ros.optimization.lm_linalg import TINY, solved


@dataclass(frozen=True)
class ProfileSettings:
    """Limits of the profile of a window's squares.

    - `distance`: standard deviations from the optimum at which the squares are compared;
    - `bent`: times more, or less, than they should have grown, beyond which the valley is bent;
    - `iterations`, `damping`: of the local search there, from a point that is near;
    - `most_widening`: times a deviation grows at most: wider ones are withheld anyway;
    - `margin`: times a deviation grows beside, as a bent valley has longer tails than a straight
      one.
    """

    distance: float = 2.0
    bent: float = 2.0
    iterations: int = 6
    damping: float = 1e-6
    most_widening: float = 5.0
    margin: float = 1.25


PROFILE = ProfileSettings()


def widened_by_profile(best: Hypothesis, settings: ProfileSettings = PROFILE) -> tuple[Array, bool]:
    """Return the covariance (d, d) of a hypothesis without a jump, and whether its window is bent.

    It is wider where the window is bent, never narrower.
    """
    posterior, z = Posterior(best.problem.objective, best.problem.prior), best.point
    deviations = np.sqrt(np.diagonal(best.covariance))
    along = best.covariance / deviations  # column k: one standard deviation of unknown k
    points = z + settings.distance * np.vstack([along.T, -along.T])
    pinned = np.tile(np.arange(z.size), 2)
    inside = ((points >= posterior.limits[0]) & (points <= posterior.limits[1])).all(axis=1)
    points, pinned = points[inside], pinned[inside]
    if not pinned.size:
        return best.covariance, False
    lowest = float(posterior.costs(z[None])[0])
    growth = (posterior.costs(points) - lowest) / settings.distance**2
    if growth.max() < settings.bent and growth.min() > 1.0 / settings.bent:
        return best.covariance, False
    probe = best.problem.settings.probe_step
    growth = (
        _optimised(posterior, points, pinned, probe, settings) - lowest
    ) / settings.distance**2
    factors = np.full(z.size, settings.margin)
    widths = 1.0 / np.sqrt(np.maximum(growth, settings.most_widening**-2))
    np.maximum.at(factors, pinned, settings.margin * widths)
    return np.asarray(best.covariance * np.outer(factors, factors)), True


def _optimised(
    posterior: Posterior, points: Array, pinned: Array, probe: float, settings: ProfileSettings
) -> Array:
    """Return the least squares (P,) around points (P, d) of which one unknown each is held.

    `probe` is the step (box) of differences.
    """
    points = points.copy()
    squares = np.full(len(points), np.inf)
    steps = np.zeros_like(points)
    for _ in range(settings.iterations):
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
            scale = np.diagonal(hessians[k]) + TINY
            step = solved(hessians[k], scale, settings.damping, -gradients[k], free)
            steps[k] = np.clip(points[k] + step, *posterior.limits) - points[k]
            points[k] += steps[k]
    return squares
