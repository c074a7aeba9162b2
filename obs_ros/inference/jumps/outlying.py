"""Outliers beside hypotheses about jumps: which samples are left out of a window, and when.

A fit without jumps that leaves few single samples far beyond the noise is fitted again without
them. In what is left, a sample's residual is that of a prediction: of variance 1 + j C j' in units
of the noise, with j (d,) the sample's row of the Jacobian and C the covariance of the fit (Cook &
Weisberg 1982, section 2.2). A sample that alone tells something is never so far out. Where a jump
may stand for them, the search for jumps decides by evidence.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from operator import attrgetter
from typing import NamedTuple

import numpy as np

from obs_ros.core.changes import replace
from obs_ros.core.deadline import Deadline
from obs_ros.core.linear_algebra import scaled_inverse
from obs_ros.core.residual_tests import is_white, like_noise, squares_of
from obs_ros.core.typing import Array, BoolArray, IntArray
from obs_ros.inference.jumps.hypothesis import Hypothesis, hypothesis_at
from obs_ros.inference.jumps.piecewise import PiecewiseProblem
from obs_ros.inference.jumps.screening import screen
from obs_ros.inference.noise import variances_left
from obs_ros.inference.outliers import OUTLIERS, left_out, outliers_in, repeated, spread
from obs_ros.inference.window_state import WindowState
from obs_ros.optimization.levenberg_marquardt import levenberg_marquardt
from obs_ros.optimization.memetic import MemeticSettings
from obs_ros.optimization.problem import Problem

Posed = Callable[[WindowState], Problem]  # what of a window is minimised


@dataclass(frozen=True)
class Cleaned:
    """A window without outliers, its optimum z (d,), and the squares of residuals and prior."""

    window: WindowState
    z: Array
    squares: float


class _Choice(NamedTuple):
    """Outliers `far` (K, r); residuals (K, r), optimum z (d,) and squares `left` without them."""

    far: BoolArray
    left: Array
    z: Array
    squares: float


@dataclass(frozen=True)
class _Found:
    """Outliers `far` (K, r), and the scaled residuals `left` (K, r) that predictions leave.

    z (d,) is the optimum of all other samples, with their squares and those of the prior. In units
    of the noise, `best` is the hypothesis on them there, and `whole` that on all samples.
    """

    far: BoolArray
    left: Array
    z: Array
    squares: float
    best: Hypothesis
    whole: Hypothesis

    @classmethod
    def of(
        cls, window: WindowState, far: BoolArray, left: Array, z: Array, squares: float
    ) -> '_Found':
        """Return what is found in a window, whose noise is that of the others if not known."""
        kept = window.without(far)
        if not window.noise_known:
            grid, objective = kept.objective.grid, kept.objective
            noise = np.sqrt(variances_left(objective.residuals(z), grid, objective.dimension))
            window, kept = (each.rescaled(noise / grid.scale) for each in (window, kept))
        best, whole = (
            hypothesis_at(PiecewiseProblem(each.objective, each.prior), z)
            for each in (kept, window)
        )
        return cls(far, left, z, squares, best, whole)


def without_outliers(
    window: WindowState,
    starts: Sequence[Array],
    deadline: Deadline,
    problem: Posed = attrgetter('posterior'),
    *,
    jumps_follow: bool = True,
    residuals: Array | None = None,
) -> Cleaned | None:
    """Return the window without its outliers and the optimum near one of the `starts` (d,).

    The last start is the optimum of all samples, which leaves `residuals` (K, r) if these are
    known. `problem` is what is minimised. None where no sample is an outlier, or, if a search for
    jumps is to follow, a jump may stand for those that seem to be.
    """
    if not window.robust or not _suspicious(window, starts[-1], residuals):
        return None
    for start in starts:
        found = _found(window, start, deadline, problem)
        if found is not None and not (jumps_follow and _may_be_jump(found)):
            return Cleaned(left_out(window, found.far, found.left), found.z, found.squares)
    return None


def beside(window: WindowState, tried: Sequence[Hypothesis]) -> tuple[BoolArray, Array] | None:
    """Return outliers (K, r) beside a hypothesis, and the scaled residuals (K, r) that it leaves.

    It is the most probable of all that were tried; None if that is one without outliers.
    """
    least, found = min(h.neg2_log_evidence for h in tried), None
    for one in tried:
        residuals = one.residuals
        far = outliers_in(window, residuals, noise_known=window.noise_known)
        if far.any() and (evidence := _without(one, far)) < least:
            least, found = evidence, (far, residuals)
    return found


def _suspicious(window: WindowState, z: Array, left: Array | None) -> bool:
    """Whether residuals (K, r) of the fit to all samples, z (d,), may hide outliers."""
    residuals = window.objective.residuals(z) if left is None else left
    if any(repeated(y[np.isfinite(y)]) for y in window.record.y.T):
        return True
    explained = _explained(window, residuals)
    if explained and window.noise_known and not (np.abs(residuals) > OUTLIERS.limit).any():
        return False
    sizes = np.abs(residuals) / spread(residuals, noise_known=window.noise_known)
    if np.nanmax(sizes, initial=0.0) > OUTLIERS.limit:
        return True
    return not explained and _tail(sizes) > OUTLIERS.tail


def _tail(sizes: Array) -> float:
    """Return the share of the squares of sizes that as many as `most`, the largest, have."""
    squares = np.sort(sizes[np.isfinite(sizes)] ** 2)
    largest = squares[squares.size - int(OUTLIERS.most * squares.size) :]
    return float(largest.sum() / max(squares.sum(), np.finfo(float).tiny))


def _found(window: WindowState, start: Array, deadline: Deadline, problem: Posed) -> _Found | None:
    """Return the outliers near a start (d,), those that are left without themselves.

    Where one comes and goes with the fit, as the sample beside it is nearly too far out, the most
    probable of the choices that alternate counts.
    """
    most, known = _fit_of_most(window, start, deadline, problem), window.noise_known
    if most is None:
        return None
    z, left = most
    least = OUTLIERS.least * np.sqrt(window.objective.signal)
    tried: list[_Choice] = []
    for _ in range(OUTLIERS.rounds + 1):
        far = outliers_in(window, left, noise_known=known) & (np.abs(left) > least)
        if not far.any():
            return None
        same = [number for number, one in enumerate(tried) if (one.far == far).all()]
        if same:
            return _Found.of(window, *_most_probable(tried[same[0] :], known=known))
        if len(tried) == OUTLIERS.rounds:
            break
        z, squares = _fitted(window.without(far), problem, z, deadline)
        if deadline.passed or not np.isfinite(squares):
            return None
        left = _predicted(hypothesis_at(PiecewiseProblem(window.objective, window.prior), z), far)
        tried.append(_Choice(far, left, z, squares))
    return None


def _most_probable(tried: Sequence[_Choice], *, known: bool) -> _Choice:
    """Return the most probable choice of outliers, in units of the noise that the best leaves.

    A `known` noise is that of the squares.
    """
    each = [one.squares / max(1, np.isfinite(one.left[~one.far]).sum()) for one in tried]
    unit = 1.0 if known else min(each)
    return min(tried, key=lambda one: one.squares + unit * OUTLIERS.penalty * one.far.sum())


def _fit_of_most(
    window: WindowState, z: Array, deadline: Deadline, problem: Posed
) -> tuple[Array, Array] | None:
    """Return the optimum (d,) near z (d,) of the samples that are not far from it themselves.

    With it come the scaled residuals (K, r) of all samples.

    At first the largest share that outliers may be is left out (concentration steps; Rousseeuw &
    Van Driessen 2006), as they may have drawn the fit to them. None where noise that is known does
    not explain the others then either: no outliers are what is wrong.
    """
    gone = np.zeros(window.record.y.shape, dtype=np.bool_)
    residuals = window.objective.residuals(z)
    for number in range(OUTLIERS.rounds):
        sizes = np.abs(residuals) / spread(residuals, noise_known=window.noise_known)
        limit, known = OUTLIERS.trimmed, sizes[~np.isnan(sizes)]
        if number < OUTLIERS.steps and known.size:
            limit = min(limit, float(np.quantile(known, 1.0 - OUTLIERS.most)))
        far = np.nan_to_num(sizes, nan=0.0) > limit
        if deadline.passed or (far == gone).all():
            break
        iterations = OUTLIERS.iterations if number < OUTLIERS.steps else None
        moved, squares = _fitted(window.without(far), problem, z, deadline, iterations)
        if not np.isfinite(squares):
            break
        gone, z, residuals = far, moved, window.objective.residuals(moved)
        rest = np.where(gone, np.nan, residuals)
        if window.noise_known and number + 1 >= OUTLIERS.steps and not _explained(window, rest):
            return None
    return z, residuals


def _explained(window: WindowState, residuals: Array) -> bool:
    """Whether noise alone may leave residuals (K, r); NaN = not measured, or left out."""
    if not window.noise_known:
        return is_white(residuals)
    counts, squares = squares_of(residuals)
    freedom = max(1, int(counts.sum()) - window.objective.dimension)
    return like_noise(float(squares.sum()), freedom, window.told_by * freedom)


def _fitted(
    window: WindowState,
    problem: Posed,
    z: Array,
    deadline: Deadline,
    iterations: int | None = None,
) -> tuple[Array, float]:
    """Return the optimum (d,) of a window near z (d,), and its squares.

    At most so many `iterations` are taken towards it.
    """
    posed, nodes = problem(window), window.objective.nodes
    most = iterations or MemeticSettings.full_iterations
    solved = levenberg_marquardt(posed, z[None], nodes, most, deadline)
    return solved.z[0], float(solved.squares[0])


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


def _may_be_jump(found: _Found) -> bool:
    """Whether a jump is more probable than outliers, to first order.

    All other samples may speak for one right before an outlier, or one may explain what seemed to
    be outliers as well as that they are none.
    """
    objective, settings = found.best.problem.objective, found.best.problem.settings
    parameters, nodes, t = objective.unknowns.may_jump, _nodes_before(found.far), objective.grid.t
    if not parameters:
        return False
    if nodes.size:
        times = (t[nodes] - t[0]) / (t[-1] - t[0])
        beside = screen(_refitted(found.best), parameters, times).gains.max()
        if beside > settings.jump_penalty:
            return True
    whole = _refitted(found.whole)
    jump = whole.cost - screen(whole, parameters).gains.max() + settings.jump_penalty
    return bool(jump < found.best.cost + OUTLIERS.penalty * found.far.sum())


def _refitted(hypothesis: Hypothesis) -> Hypothesis:
    """Return a hypothesis that is no optimum with the residual and cost of one, to first order."""
    point, problem, linear = hypothesis.point, hypothesis.problem, hypothesis.linearisation
    off, precision = point - problem.mean(point), problem.precision(point)
    pull = linear.jacobian.T @ linear.residual + precision @ off
    low, high = problem.limits
    pull[(point <= low) | (point >= high)] = 0.0
    step = hypothesis.covariance @ pull
    residual = linear.residual - linear.jacobian @ step
    cost = float(residual @ residual + (off - step) @ precision @ (off - step))
    return replace(hypothesis, linearisation=replace(linear, residual=residual), cost=cost)


def _nodes_before(found: BoolArray) -> IntArray:
    """Return the nodes right before outliers (K, r) at which a jump may stand for one."""
    back = np.arange(1, OUTLIERS.before + 1)
    nodes = np.unique(np.flatnonzero(found.any(axis=1))[:, None] - back)
    return nodes[(nodes >= 1) & (nodes <= len(found) - 2)]


def _without(best: Hypothesis, found: BoolArray) -> float:
    """Return -2 log evidence of a hypothesis beside outliers (K, r), fitted to them though."""
    return best.neg2_log_evidence - float(np.sum(best.residuals[found] ** 2 - OUTLIERS.penalty))
