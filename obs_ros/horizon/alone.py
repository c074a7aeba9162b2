"""A window that is solved by itself: from its fit to its estimate, without any that came before."""

import numpy as np

from obs_ros.core.deadline import Deadline
from obs_ros.core.estimate import Estimate
from obs_ros.core.typing import Array
from obs_ros.horizon.bases import Bases
from obs_ros.horizon.cleaning import WITH_GIVEN_PRIORS, cleaned, rescaled_to_residuals
from obs_ros.horizon.disturbance import assessed, explain_by_process_noise, steadied, untried
from obs_ros.horizon.given_priors import under_given_priors
from obs_ros.horizon.integration_error import Answer
from obs_ros.horizon.intervals import with_intervals
from obs_ros.inference.assessment.assemble import report
from obs_ros.inference.assessment.informed_subspace import marginal_information
from obs_ros.inference.assessment.lateness import looks_late, remarked
from obs_ros.inference.assessment.uncertainty import Uncertainty
from obs_ros.inference.jumps.hypothesis import hypothesis_at
from obs_ros.inference.jumps.piecewise import PiecewiseProblem
from obs_ros.inference.process_noise import ProcessNoiseMode
from obs_ros.inference.window_state import WindowState
from obs_ros.optimization.refinement import refined
from obs_ros.optimization.result import Found


def explained_alone(
    window: WindowState, found: Found, given: Array, mode: ProcessNoiseMode, deadline: Deadline
) -> tuple[Estimate, Answer]:
    """Return the estimate by a fit of least squares, and the integration error of its answer.

    `given` (r,) are the outputs' known deviations, NaN where they are not.
    """
    if not window.noise_known:
        window, found = rescaled_to_residuals(window, found)
    found = under_given_priors(window, found, deadline, polish=True)
    window, found = cleaned(window, found, deadline, WITH_GIVEN_PRIORS, jumps_follow=False)
    found = refined(window.with_given_priors, found, deadline)
    best = hypothesis_at(PiecewiseProblem(window.objective, window.prior), found.z)
    remark = str(looks_late(best) or '')
    other = explain_by_process_noise(window, found, best, given, deadline, mode=mode)
    if other is not None:
        window, other = steadied(window, other, given, deadline, mode=mode)
        if mode == 'auto':
            bases = Bases(window, best, other)
            other = bases.window(bases.by_cross_validation())
        window, found, best = other.window, other.found, other.hypothesis
    information = marginal_information(best, window.objective.unknowns.n_states)
    tried = other is not None or not found.accepted
    late = not tried and untried(window, best, mode, deadline)
    uncertainty = Uncertainty(best, best.covariance, information, finished=not late)
    uncertainty = uncertainty if other is None else other.added_to(uncertainty)
    uncertainty = assessed(uncertainty, mode)
    uncertainty = with_intervals(uncertainty, other, found, deadline)
    answer = Answer.of(window, found.z, uncertainty.hypothesis, uncertainty.noise)
    estimate = report(window, found, uncertainty, in_time=not deadline.passed, solve_time=np.nan)
    return remarked(estimate, remark), answer


def best_alone(window: WindowState, found: Found, deadline: Deadline) -> tuple[Estimate, Answer]:
    """Return the estimate by the best point of a search that needs no squares."""
    found = under_given_priors(window, found, deadline, polish=False)
    answer = Answer.of(window, found.z)
    estimate = report(window, found, None, in_time=not deadline.passed, solve_time=np.nan)
    return estimate, answer
