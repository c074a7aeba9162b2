"""The last steps of a fit: its optimum, as far as it matters, wherever the search came from.

A search stops where a step would gain a hundredth of what a fit's squares scatter by. That tells
optima apart, but leaves unknowns up to two tenths of a deviation off, and elsewhere from another
start. Gauss-Newton steps, which converge fast there (Nocedal & Wright 2006, section 10.3), make the
one fit that is believed a function of the data.
"""

from dataclasses import dataclass

import numpy as np

from obs_ros.core.changes import replace
from obs_ros.core.deadline import Deadline
from obs_ros.core.typing import Array
from obs_ros.optimization.levenberg_marquardt import LM_DEFAULTS, LMSettings
from obs_ros.optimization.lm_linalg import last_step
from obs_ros.optimization.problem import Linearised, Problem
from obs_ros.optimization.result import Found


@dataclass(frozen=True)
class RefinementSettings:
    """Limits of the last steps.

    - `gain`: of a step, as a share of d times the noise variance, below which it is not taken:
      it would move no combination of unknowns by more than sqrt(d) 1e-4 deviations;
    - `steps`: at most; a window that takes more is so bent that deviations mean little;
    - `difference`: first step of the differences, in boxes; later ones follow the noise. A tenth of
      it leaves ten times the rounding errors in the first step, and so in the optimum.
    """

    gain: float = 1e-8
    steps: int = 4
    difference: float = 1e-7


REFINEMENT = RefinementSettings()
# The same for a fit that begins farther away; damping would slow down what is left to gain.
REFINED = replace(LM_DEFAULTS, converged_gain=REFINEMENT.gain, damping=1e-6)


def refined(
    problem: Problem, found: Found, deadline: Deadline, settings: RefinementSettings = REFINEMENT
) -> Found:
    """Return the fit at its optimum, to a small share of the deviations of its unknowns.

    It never costs more than at the start of these steps.
    """
    z, squares, hessian = _refined(problem, found.z, problem.nodes, deadline, settings)
    found = replace(found, curvature=np.diagonal(hessian))
    return found if z is found.z else replace(found, z=z, cost=squares)


def refined_point(
    problem: Linearised,
    start: Array,
    nodes: int,
    deadline: Deadline,
    settings: RefinementSettings = REFINEMENT,
    local: LMSettings = LM_DEFAULTS,
) -> tuple[Array, float]:
    """Return the optimum (d,) near a start (d,), and its squares; the start where no step helps."""
    return _refined(problem, start, nodes, deadline, settings, local)[:2]


def _refined(
    problem: Linearised,
    start: Array,
    nodes: int,
    deadline: Deadline,
    settings: RefinementSettings,
    local: LMSettings = LM_DEFAULTS,
) -> tuple[Array, float, Array]:
    """Return the optimum (d,), its squares, and their Hessian (d, d)."""
    z = start
    least, freedom = problem.floor(nodes), max(1, problem.count(nodes) - z.size)
    at = problem.linearise(z[None], np.full((1, z.size), settings.difference), nodes)
    squares, gradient, hessian = at
    for _ in range(settings.steps):
        if deadline.passed:
            break
        variance = max(least, float(squares[0])) / freedom
        trial, h, worth = last_step(
            z[None], squares, gradient, hessian, problem.limits,
            settings.gain * z.size * variance, variance, local.rules,
        )  # fmt: skip
        if not worth:
            break
        at = problem.linearise(trial, h, nodes)
        if not at[0][0] < squares[0]:
            break
        z = trial[0]
        squares, gradient, hessian = at
    return z, float(squares[0]), hessian[0]
