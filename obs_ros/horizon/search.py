"""The search of a window whose outputs may wrap.

Residuals by the shortest way round are right for every record, but their squares have false minima
wherever a candidate turns too fast or too slowly. Records come without wraps, each output from one
value to the next by the shortest way, and squares of residuals as they are have no such minima. So
these are minimised first. Their optimum is believed where what it leaves is noise and no residual
is longer than half a period; a gap or an outlier in which the shortest way was not that of the
plant shows there, and so do sensors of one angle that are whole turns apart. Else residuals by the
shortest way decide, with that optimum among their starts.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from obs_ros.core.deadline import Deadline
from obs_ros.core.typing import Array
from obs_ros.inference.objective import Objective
from obs_ros.inference.prior import Posterior
from obs_ros.optimization.acceptance import Acceptance
from obs_ros.optimization.methods import Method
from obs_ros.optimization.result import Found


@dataclass(frozen=True)
class WrapSettings:
    """Limit in searching windows whose outputs wrap.

    - `same`: share of the cost by which the shortest way round may lower it, where no residual is
      longer than half a period: only rounding does.
    """

    same: float = 1e-6


WRAPS = WrapSettings()
# The rules by which what an optimum leaves is noise.
NOISE = (Acceptance.LIKE_NOISE, Acceptance.WHITE_ROUNDS, Acceptance.WHITE_SURVIVORS)


def searched(
    method: Method,
    settings: Any,
    problem: Objective | Posterior,
    rng: np.random.Generator,
    deadline: Deadline,
    warm: Array | None,
    known: bool,
) -> Found:
    """Return the optimum of a window's costs; arguments as of `Search`."""
    if problem.wraps:
        found = method.search(problem.straight, rng, deadline, settings, warm, known)
        cost = float(problem.costs(found.z[None])[0])
        if found.accepted in NOISE and cost >= found.cost * (1.0 - WRAPS.same):
            return found
        warm = found.z
    return method.search(problem, rng, deadline, settings, warm, known)
