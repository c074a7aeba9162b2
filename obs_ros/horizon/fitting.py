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
from obs_ros.optimization.acceptance import Acceptance
from obs_ros.optimization.levenberg_marquardt import LMSettings, Trail, levenberg_marquardt
from obs_ros.optimization.memetic import MemeticSettings
from obs_ros.optimization.neighbourhood import bettered
from obs_ros.optimization.result import Found

Costs = Objective | Posterior
UNEXPLAINED = None, Acceptance.ROUNDS  # by which noise does not explain an optimum
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

    Where every candidate diverges the next method of integration is tried. An optimum by steps of
    the candidates' own that noise does not explain is compared with its neighbours, and sought
    once more in finer ones. Where the optimum errs too much it is found anew in finer steps, from
    there: by a local search of `squares` if it was one that noise explains.
    """
    found = search(problem, warm)
    while not np.isfinite(found.cost) and (other := integration.otherwise(window)) is not None:
        window = other
        found = search(of_window(problem, window), warm)
    problem = of_window(problem, window)
    if squares and window.objective.grid.tolerance and found.accepted is not Acceptance.LIKE_NOISE:
        found = bettered(problem, found, deadline, noise_known=window.noise_known)
        if found.accepted in UNEXPLAINED and warm is None and not deadline.passed:
            window, found = _in_finer_steps(window, problem, found, search, integration, deadline)
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
    return integration.counted(window, found.z), found


def _in_finer_steps(
    window: WindowState,
    problem: Costs,
    found: Found,
    search: Search,
    integration: Integration,
    deadline: Deadline,
) -> tuple[WindowState, Found]:
    """Return the better of an optimum that noise does not explain and one sought in finer steps.

    Own steps of candidates leave costs that are smooth on the scale of their tolerance alone: by
    relaxing plants that decides where a search ends.
    """
    finer = integration.tighter(window)
    if finer is window:
        return window, found
    problem = of_window(problem, finer)
    other = search(problem, found.z)
    if other.accepted is not Acceptance.LIKE_NOISE:
        other = bettered(problem, other, deadline, noise_known=window.noise_known)
    return (finer, other) if other.cost < found.cost else (window, found)


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
