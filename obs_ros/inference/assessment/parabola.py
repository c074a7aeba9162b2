"""Whether the parabola at an optimum tells the cost where its deviations end.

Where it does, the deviations of the curvature stand; elsewhere profiles are needed, see
`profile.py`.
"""

from dataclasses import dataclass

import numpy as np

from obs_ros.core.typing import Array, IntArray
from obs_ros.inference.jumps.piecewise import PiecewiseProblem
from obs_ros.inference.prior import Posterior
from obs_ros.optimization.lm_linalg import TINY


@dataclass(frozen=True)
class ParabolaSettings:
    """Limits within which a cost is a parabola.

    - `share`: of its growth at the parabola's ends, by which the cost may differ there.
    """

    share: float = 0.2


PARABOLA = ParabolaSettings()


def parabola_holds(
    posterior: Posterior | PiecewiseProblem,
    z: Array,
    gradient: Array,
    covariance: Array,
    pinned: IntArray,
    level: float,
    settings: ParabolaSettings = PARABOLA,
) -> bool:
    """Whether the cost grows by `level` where the parabola of a covariance (d, d) says so.

    That is at both ends of the intervals of `pinned` unknowns (q,), the others moving along; all
    must be inside the limits. A search ends where hardly anything is left to gain: `gradient`
    (d,), half that of the cost at z (d,), tells which side grows by how much more.
    """
    if not np.isfinite(covariance).all():
        return False
    deviations = np.sqrt(np.maximum(np.diagonal(covariance), TINY))
    along = np.sqrt(level) * (covariance / deviations).T[pinned]
    points = np.vstack([z[None], z - along, z + along])
    if not ((points >= posterior.limits[0]) & (points <= posterior.limits[1])).all():
        return False
    costs = posterior.costs(points)
    leaning = 2.0 * (points[1:] - z) @ gradient
    growth = (costs[1:] - costs[0] - leaning) / level
    return bool((np.abs(growth - 1.0) <= settings.share).all())
