"""The fit of one window: searched, in steps that suffice for its optimum, and weighted anew."""

from collections.abc import Callable
from functools import partial

import numpy as np

from obs_ros.core.changes import replace
from obs_ros.core.deadline import Deadline
from obs_ros.core.typing import Array, BoolArray
from obs_ros.horizon.settings import POSING
from obs_ros.horizon.stepping import Integration
from obs_ros.inference.assessment.fit import root_mean_square
from obs_ros.inference.objective import Objective
from obs_ros.inference.prior import Posterior
from obs_ros.inference.window_state import WindowState
from obs_ros.optimization.levenberg_marquardt import LMSettings, Trail, levenberg_marquardt
from obs_ros.optimization.memetic import MemeticSettings
from obs_ros.optimization.result import Found

Costs = Objective | Posterior
Search = Callable[[Costs, Array | None], Found]  # by costs and a start (d,)


def fitted(
    window: WindowState,
    problem: Costs,
    search: Search,
    integration: Integration,
    deadline: Deadline,
    warm: Array | None,
    *,
    squares: bool,
) -> tuple[WindowState, Found]:
    """Return the optimum of a window's objective or posterior, the `problem`, and the window.

    Where every candidate diverges the next method of integration is tried. Where the optimum errs
    too much it is found anew in finer steps, from there: by a local search of `squares` if it was
    one that noise explains.
    """
    found = search(problem, warm)
    if not np.isfinite(found.cost) and (other := integration.otherwise(window)) is not None:
        window = other
        found = search(of_window(problem, window), warm)
    if warm is None and not found.accepted and not deadline.passed:
        window, found = _in_denser_steps(window, problem, found, search, integration)
        problem = of_window(problem, window)
    for _ in range(integration.attempts):
        if window.exact or deadline.passed or not np.isfinite(found.cost):
            break
        finer = integration.refined(window, found.z)
        if finer is window:
            break
        window = finer
        problem = of_window(problem, window)
        if squares and found.accepted:
            found = polished(problem, found, deadline)
        else:
            found = search(problem, found.z)
    return window, found


def _in_denser_steps(
    window: WindowState,
    problem: Costs,
    found: Found,
    search: Search,
    integration: Integration,
) -> tuple[WindowState, Found]:
    """Return the better of an optimum that noise does not explain and one sought in finer steps.

    Steps are chosen by a spread of candidates, of which most may be off: where the plant is stiff
    the costs about the optimum may be wrong, and lead a search elsewhere.
    """
    denser = integration.denser(window)
    if denser is window:
        return window, found
    other = search(of_window(problem, denser), None)
    return (denser, other) if other.cost < found.cost else (window, found)


def of_window(problem: Costs, window: WindowState) -> Costs:
    """Return the costs of the same kind for the objective of another window."""
    if isinstance(problem, Posterior):
        return Posterior(window.objective, problem.prior)
    return window.objective


def polished(problem: Costs, found: Found, deadline: Deadline) -> Found:
    """Return the optimum near one that was found in other steps."""
    solved = levenberg_marquardt(
        problem, found.z[None], problem.nodes, MemeticSettings.full_iterations, deadline
    )
    return replace(
        found,
        z=solved.z[0],
        cost=float(solved.squares[0]),
        converged=bool(solved.converged[0]),
    )


def reweighted(
    window: WindowState, found: Found, guessed: BoolArray, deadline: Deadline
) -> tuple[WindowState, Found]:
    """Weight the outputs by their own residuals where the guess of their noise was off.

    `guessed` (r,) are those whose noise is not given.
    """
    objective = window.objective
    share = LMSettings.same_optimum * objective.dimension / objective.count(objective.nodes)
    for _ in range(POSING.reweightings if guessed.any() and guessed.size > 1 else 0):
        if deadline.passed:
            break
        rms = root_mean_square(window.objective.residuals(found.z))
        off = np.where(guessed & (rms > 0.0), rms, 1.0)
        if off.max() < POSING.unequal * off.min():
            break
        window = window.rescaled(off)
        polish = levenberg_marquardt(
            window.objective,
            found.z[None],
            objective.nodes,
            MemeticSettings.full_iterations,
            deadline,
            hopeless=partial(_hardly_fall, Trail(MemeticSettings.patience), share),
        )
        found = replace(found, z=polish.z[0], cost=float(polish.squares[0]))
    return window, found


def _hardly_fall(trail: Trail, share: float, squares: float) -> bool:
    """Whether squares have fallen by less than this share of them in the latest rollouts."""
    return trail.gain(squares) < share * squares
