"""Windows in units of what their fit leaves, and without outliers."""

from operator import attrgetter

import numpy as np

from obs_ros.core.changes import replace
from obs_ros.core.deadline import Deadline
from obs_ros.core.residual_tests import like_noise
from obs_ros.core.typing import Array
from obs_ros.inference.jumps.hypothesis import Hypothesis, hypothesis_at
from obs_ros.inference.jumps.outlying import Posed, without_outliers
from obs_ros.inference.jumps.piecewise import PiecewiseProblem
from obs_ros.inference.noise import variances_left
from obs_ros.inference.window_state import WindowState
from obs_ros.optimization.acceptance import Acceptance
from obs_ros.optimization.levenberg_marquardt import levenberg_marquardt
from obs_ros.optimization.memetic import MemeticSettings
from obs_ros.optimization.problem import Problem
from obs_ros.optimization.refinement import refined
from obs_ros.optimization.result import Found

POLISH = 40  # iterations of a local search that starts near its optimum
POSTERIOR: Posed = attrgetter('posterior')
WITH_GIVEN_PRIORS: Posed = attrgetter('with_given_priors')


def cleaned(
    window: WindowState,
    found: Found,
    deadline: Deadline,
    problem: Posed = POSTERIOR,
    *,
    jumps_follow: bool = True,
    residuals: Array | None = None,
) -> tuple[WindowState, Found]:
    """Return the window without outliers, if there are any, and its optimum near the one found.

    `problem` is what the fit minimises, residuals (K, r) are those that it leaves, if they are
    known; see `without_outliers`.
    """
    if not np.isfinite(found.cost):
        return window, found
    clean = without_outliers(
        window, [found.z], deadline, problem, jumps_follow=jumps_follow, residuals=residuals
    )
    if clean is None:
        return window, found
    return _accepted(clean.window, replace(found, z=clean.z, cost=clean.squares), deadline, problem)


def refitted(window: WindowState, found: Found, deadline: Deadline) -> tuple[WindowState, Found]:
    """Return a window that outliers were left out of, and its optimum near the one found."""
    z, squares = polished(window.posterior, found.z, deadline)
    found = replace(found, z=z, cost=squares)
    return _accepted(window, found, deadline, POSTERIOR)


def plain_fit(
    window: WindowState, found: Found, starts: Array, deadline: Deadline
) -> tuple[WindowState, Hypothesis | None]:
    """Return the best optimum without process noise near some starts (P, d), in its own scales."""
    posterior, most = window.posterior, MemeticSettings.full_iterations
    solved = levenberg_marquardt(posterior, starts, posterior.nodes, most, deadline)
    if deadline.passed or not np.isfinite(solved.squares[0]):
        return window, None
    found = replace(found, z=solved.z[0], cost=float(solved.squares[0]))
    found = refined(posterior, found, deadline)
    if not window.noise_known:
        window, found = rescaled_to_residuals(window, found)
    return window, hypothesis_at(PiecewiseProblem(window.objective, window.prior), found.z)


def without_the_same(posed: WindowState, window: WindowState) -> WindowState:
    """Return a posed window without the outliers that another of the same samples is without."""
    if len(window.outliers) == len(posed.outliers):
        return posed
    gone = np.isfinite(posed.record.y) & np.isnan(window.record.y)
    return replace(posed.without(gone), outliers=window.outliers)


def _accepted(
    window: WindowState, found: Found, deadline: Deadline, problem: Posed
) -> tuple[WindowState, Found]:
    """Return the fit of a window without outliers: in units of the noise, like noise if it is."""
    if not window.noise_known:
        return in_own_scale(window, found, deadline, problem)
    objective = window.objective
    freedom = max(1, objective.count(objective.nodes) - objective.dimension)
    if not found.accepted and like_noise(found.cost, freedom):
        found = replace(found, accepted=Acceptance.LIKE_NOISE)
    return window, found


def in_own_scale(
    window: WindowState, found: Found, deadline: Deadline, problem: Posed = POSTERIOR
) -> tuple[WindowState, Found]:
    """Return the window in units of what the fit leaves, and its optimum there."""
    window, found = rescaled_to_residuals(window, found)
    z, squares = polished(problem(window), found.z, deadline)
    return window, replace(found, z=z, cost=squares)


def polished(
    problem: Problem | PiecewiseProblem, start: Array, deadline: Deadline
) -> tuple[Array, float]:
    """Return the optimum (D,) near a start (D,), and its squares."""
    solved = levenberg_marquardt(problem, start[None], problem.nodes, POLISH, deadline)
    return solved.z[0], float(solved.squares[0])


def rescaled_to_residuals(window: WindowState, found: Found) -> tuple[WindowState, Found]:
    """Scale the outputs by the residuals of a fit; return the fit with its cost in that."""
    objective = window.objective
    residuals = objective.residuals(found.z)
    factors = np.sqrt(variances_left(residuals, objective.grid, objective.dimension))
    factors /= objective.grid.scale
    cost = float(np.nansum((residuals / factors) ** 2))
    return window.rescaled(factors), replace(found, cost=cost)
