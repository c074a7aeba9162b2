"""Given priors in a window that is solved by itself, where boxes count as limits only."""

from dataclasses import replace

from obs_ros.core.deadline import Deadline
from obs_ros.inference.window_state import WindowState
from obs_ros.optimization.levenberg_marquardt import levenberg_marquardt
from obs_ros.optimization.memetic import MemeticSettings
from obs_ros.optimization.result import Found


def under_given_priors(
    window: WindowState, found: Found, deadline: Deadline, *, polish: bool
) -> Found:
    """Return the fit with the given priors' share taken off its cost.

    With `polish` it is the optimum near there: only once the noise is known are squares in its
    units, in which those of priors count beside them.
    """
    objective, problem = window.objective, window.with_given_priors
    if problem is objective:
        return found
    z = found.z
    if polish:
        iterations = MemeticSettings.full_iterations
        z = levenberg_marquardt(problem, z[None], objective.nodes, iterations, deadline).z[0]
    return replace(found, z=z, cost=float(objective.costs(z[None])[0]))
