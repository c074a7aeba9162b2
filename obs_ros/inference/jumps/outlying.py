"""Outliers beside hypotheses about jumps: which samples are left out of a window, and when.

A fit without jumps that leaves few single samples far beyond the noise is fitted again without
them. In what is left, a sample's residual is that of a prediction: of variance 1 + j C j' in units
of the noise, with j (d,) the sample's row of the Jacobian and C the covariance of the fit (Cook &
Weisberg 1982, section 2.2). A sample that alone tells something is never so far out. Where a jump
may stand for them, the search for jumps decides by evidence.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from operator import attrgetter

import numpy as np

from obs_ros.core.deadline import Deadline
from obs_ros.core.linear_algebra import scaled_inverse
from obs_ros.core.typing import Array, BoolArray, IntArray
from obs_ros.inference.jumps.hypothesis import Hypothesis, hypothesis_at
from obs_ros.inference.jumps.piecewise import PiecewiseProblem, may_jump
from obs_ros.inference.jumps.screening import screen
from obs_ros.inference.outliers import OUTLIERS, left_out, suspects
from obs_ros.inference.window_state import WindowState
from obs_ros.optimization.levenberg_marquardt import levenberg_marquardt
from obs_ros.optimization.memetic import MemeticSettings
from obs_ros.optimization.problem import Problem


@dataclass(frozen=True)
class Cleaned:
    """A window without outliers, its optimum z (d,), and the squares of residuals and prior."""

    window: WindowState
    z: Array
    squares: float


def without_outliers(
    window: WindowState,
    z: Array,
    deadline: Deadline,
    problem: Callable[[WindowState], Problem] = attrgetter('posterior'),
) -> Cleaned | None:
    """Return the window without its outliers and the optimum near z (d,), that of all samples.

    `problem` is what is minimised. None where no sample is an outlier, or a jump may stand for
    those that seem to be.
    """
    residuals = _residuals(window, z)
    found = suspects(residuals, noise_known=window.noise_known)
    if found.any():
        found &= np.abs(residuals) > OUTLIERS.least * np.sqrt(window.objective.signal)
    if not found.any():
        return None
    start = z
    for _ in range(OUTLIERS.rounds):
        cleaned = _refitted(window.without(found), problem, z, deadline)
        if deadline.passed or not np.isfinite(cleaned.squares):
            return None
        full = hypothesis_at(PiecewiseProblem(window.objective, window.prior), cleaned.z)
        left = _predicted(full, found)
        again = suspects(left, noise_known=window.noise_known)
        again &= found | (np.abs(left) >= OUTLIERS.comparable * np.nanmax(np.abs(left)))
        if (again == found).all():
            break
        found, z = again, cleaned.z
        if not found.any():
            return None
    else:
        return None
    whole = hypothesis_at(PiecewiseProblem(window.objective, window.prior), start)
    if _may_be_jump(whole, cleaned.window, found, cleaned.z):
        return None
    return replace(cleaned, window=left_out(window, found, left))


def beside(tried: Sequence[Hypothesis], *, noise_known: bool) -> tuple[BoolArray, Array] | None:
    """Return outliers (K, r) beside a hypothesis, and the scaled residuals (K, r) that it leaves.

    It is the most probable of all that were tried; None if that is one without outliers.
    """
    least, found = min(h.neg2_log_evidence for h in tried), None
    for one in tried:
        residuals = one.residuals
        far = suspects(residuals, noise_known=noise_known)
        if far.any() and (evidence := _without(one, far)) < least:
            least, found = evidence, (far, residuals)
    return found


def _residuals(window: WindowState, z: Array) -> Array:
    """Return scaled residuals (K, r) of a point; it counts as no candidate of a search."""
    objective, grid = window.objective, window.objective.grid
    _, outputs = objective.kernels.trajectories(grid, *objective.unknowns.values(z[None]))
    weight = np.where(grid.weight > 0.0, grid.weight, np.nan)
    return np.asarray(weight * (outputs[:, :, 0] - grid.y))


def _refitted(
    window: WindowState, problem: Callable[[WindowState], Problem], z: Array, deadline: Deadline
) -> Cleaned:
    """Return a window without some samples, and its optimum near z (d,)."""
    posed, nodes = problem(window), window.objective.nodes
    iterations = MemeticSettings.full_iterations
    solved = levenberg_marquardt(posed, z[None], nodes, iterations, deadline)
    return Cleaned(window, solved.z[0], float(solved.squares[0]))


def _predicted(full: Hypothesis, found: BoolArray) -> Array:
    """Return scaled residuals (K, r) of all samples at the optimum without those `found`.

    Those are in deviations of the prediction, in which the others tell them.
    """
    out = found[full.problem.objective.grid.weight > 0.0]
    rows, residuals = full.linearisation.jacobian, full.residuals
    kept = rows[~out]
    covariance = scaled_inverse(kept.T @ kept + full.problem.prior.precision)
    variance = 1.0 + ((rows[out] @ covariance) * rows[out]).sum(axis=1)
    residuals[found] /= np.sqrt(variance)
    return residuals


def _may_be_jump(full: Hypothesis, window: WindowState, found: BoolArray, z: Array) -> bool:
    """Whether a jump may stand for outliers (K, r) of the window without them, of optimum z (d,).

    `full` is the hypothesis that no sample is an outlier. Beside one, other samples speak for a
    jump right before it; several may be those of one jump alone.
    """
    parameters = may_jump(window.objective.unknowns)
    nodes = _nodes_before(found)
    if not parameters or not nodes.size:
        return False
    t = window.objective.grid.t
    times = (t[nodes] - t[0]) / (t[-1] - t[0])
    best = hypothesis_at(PiecewiseProblem(window.objective, window.prior), z)
    if screen(best, times, parameters).gains.max() > OUTLIERS.hint:
        return True
    if found.sum() < 2:
        return False
    parts = full.problem.settings.times
    anywhere = np.union1d(times, np.arange(1, parts) / parts)
    squares = float(np.sum(full.residuals[found] ** 2))
    return bool(screen(full, anywhere, parameters).gains.max() > OUTLIERS.together * squares)


def _nodes_before(found: BoolArray) -> IntArray:
    """Return the nodes right before outliers (K, r) at which a jump may stand for one."""
    back = np.arange(1, OUTLIERS.before + 1)
    nodes = np.unique(np.flatnonzero(found.any(axis=1))[:, None] - back)
    return nodes[(nodes >= 1) & (nodes <= len(found) - 2)]


def _without(best: Hypothesis, found: BoolArray) -> float:
    """Return -2 log evidence of a hypothesis beside outliers (K, r), fitted to them though."""
    return best.neg2_log_evidence - float(np.sum(best.residuals[found] ** 2 - OUTLIERS.penalty))
