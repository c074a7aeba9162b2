"""The stage that finds two-sided intervals, where deviations are given."""

from obs_ros.core.changes import replace
from obs_ros.core.deadline import Deadline
from obs_ros.horizon.disturbance import DisturbedWindow
from obs_ros.inference.assessment.informed_subspace import marginal_information
from obs_ros.inference.assessment.interval import determined
from obs_ros.inference.assessment.outcome import is_told
from obs_ros.inference.assessment.uncertainty import Uncertainty
from obs_ros.optimization.result import Found


def with_intervals(
    uncertainty: Uncertainty, other: DisturbedWindow | None, found: Found, deadline: Deadline
) -> Uncertainty:
    """Return the uncertainty without the pull of boxes, and intervals by profiles where needed.

    Where deviations are withheld anyway there is nothing to find. A profile is one of the
    likelihood: it tells nothing of a window that noise, and process noise, do not explain. An
    `other` model that has a covariance of its own, as output error has, keeps it.
    """
    fit = uncertainty.fit
    own = other is not None and other.covariance is not None
    if own or not is_told(uncertainty, found, fit):
        return uncertainty
    before = uncertainty.hypothesis
    movable = uncertainty.process_noise is None
    # Jumps beside process noise have none: their times are unknowns too, which costs too much.
    profiled = fit.is_noise and (movable or not before.problem.events)
    known = determined(before, fit.enlargement, deadline, movable=movable, profiled=profiled)
    information = uncertainty.information
    if known.hypothesis is not before:
        states = before.problem.objective.unknowns.n_states
        information = marginal_information(known.hypothesis, states)
    return replace(
        uncertainty,
        hypothesis=known.hypothesis,
        covariance=known.covariance,
        information=information,
        interval=known.interval,
        finished=not deadline.passed,
    )
