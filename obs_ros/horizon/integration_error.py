"""The integration error of an answer, in standard deviations of the noise."""

from dataclasses import dataclass

import numpy as np

from obs_ros.core.changes import replace
from obs_ros.core.estimate import Estimate, Outcome
from obs_ros.core.periods import shortest
from obs_ros.core.residual_tests import squares_of
from obs_ros.core.typing import Array
from obs_ros.inference.assessment.fit import root_mean_square
from obs_ros.inference.jumps.hypothesis import Hypothesis
from obs_ros.inference.jumps.piecewise import PiecewiseProblem
from obs_ros.inference.noise import noise_guess
from obs_ros.inference.objective import Objective
from obs_ros.inference.window_state import WindowState
from obs_ros.integration.grid import Grid
from obs_ros.integration.step_trials import STEPPING, counted_together, doubling_error, own_error
from obs_ros.optimization.lm_linalg import TINY

# Outcomes of answers that are believed as they stand.
SOUND = (Outcome.CONVERGED, Outcome.AT_BOUND, Outcome.NOT_IDENTIFIABLE)


@dataclass(frozen=True)
class NoiseFloor:
    """Limit of what counts as noise.

    - `share`: of the standard deviation of an output's values, below which noise is not believed:
      100 dB, as hardly any sensor has, while what rounds or is computed leaves less;
    - `rounding`: share of the largest value, beside which rollouts round.
    """

    share: float = 1e-5
    rounding: float = 1e-9


FLOOR = NoiseFloor()


def noise_of(window: WindowState, residuals: Array | None = None) -> Array:
    """Return the noise (r,) in the outputs' units beside which integration errors are judged.

    It is given, learned or guessed; at an optimum it is what that leaves, scaled residuals (K, r),
    where these are larger than known noise, or where noise is not known.
    """
    objective = window.objective
    grid = objective.grid
    if not objective.is_least_squares:
        columns = zip(grid.values.T, grid.rounding.tolist(), strict=True)
        scale = np.array([noise_guess(y, rounding=rounding) for y, rounding in columns])
    else:
        scale = grid.scale
    if residuals is not None and objective.is_least_squares:
        sizes = root_mean_square(residuals)
        if window.noise_known:
            sizes = np.maximum(1.0, root_mean_square(residuals.reshape(-1, 1)))
        scale = scale * np.where(np.isfinite(sizes) & (sizes > 0.0), sizes, 1.0)
    if (scale > FLOOR.share * np.abs(grid.y).max(axis=0)).all():  # which exceeds any deviation
        return np.asarray(scale)
    return np.asarray(np.maximum(scale, least_noise(grid)))


def least_noise(grid: Grid) -> Array:
    """Return what is the least noise (r,) to be believed, in the outputs' units."""
    known = grid.weight > 0.0
    share = known / np.maximum(1, known.sum(axis=0))
    mean = np.sum(share * grid.y, axis=0)
    deviations = np.sqrt(np.sum(share * (grid.y - mean) ** 2, axis=0))
    rounding = FLOOR.rounding * np.abs(grid.y).max(axis=0) + np.finfo(np.float64).tiny
    return np.asarray(np.maximum(FLOOR.share * deviations, rounding))


def errors_at(
    problem: Objective | PiecewiseProblem,
    point: Array,
    rolled: tuple[Array, Array] | None = None,
) -> Array:
    """Return the integration errors (K, r) of a point's scaled residuals; 0 where there is none.

    They are found by a rollout with twice as many steps, or with much finer ones of its own; of a
    corrected rollout they are those of the innovations. `rolled` are the point's states (K, n) and
    scaled residuals (K, r), if they are known.
    """
    objective = problem if isinstance(problem, Objective) else problem.objective
    grid = objective.grid
    if objective.unknowns.model.period is not None:
        return np.zeros(grid.weight.shape)  # a discrete model integrates nothing
    finer = replace(objective, grid=grid.finer())
    other = finer if isinstance(problem, Objective) else replace(problem, objective=finer)
    rolled = rolled or problem.trajectory(point)
    with np.errstate(all='ignore'):
        difference = shortest(other.trajectory(point)[1] - rolled[1], grid.weight * grid.period)
        method = objective.kernels.model.method
        size = own_error(difference) if grid.is_free else doubling_error(difference, method)
        error = np.copysign(size, difference)
    known = grid.weight > 0.0
    if grid.ends is not None:
        known = known & ~grid.ends.saturated
    return np.where(known, error, 0.0)


def error_at(
    problem: Objective | PiecewiseProblem,
    point: Array,
    noise: Array,
    rolled: tuple[Array, Array] | None = None,
) -> float:
    """Return what the integration errors at a point count for, in deviations of noise (r,).

    See `errors_at` for the arguments, and `counted_together`.
    """
    objective = problem if isinstance(problem, Objective) else problem.objective
    errors = in_deviations(errors_at(problem, point, rolled), objective.grid, noise)
    return counted_together(largest(errors), float(np.sqrt(np.sum(errors * errors))))


def in_deviations(errors: Array, grid: Grid, noise: Array) -> Array:
    """Return errors (K, r) of scaled residuals in deviations of noise (r,)."""
    return errors if grid.injection is not None else np.asarray(errors * (grid.scale / noise))


def largest(values: Array) -> float:
    """Return the largest size of some values; of what is no number it is infinite."""
    found = float(np.abs(values).max(initial=0.0))
    return found if np.isfinite(found) else np.inf


def moved(best: Hypothesis, errors: Array) -> float:
    """Return by how many of its deviations the unknown moves that integration moves by most.

    The optimum of exact integration is one Gauss-Newton step away: C J'e by errors e (K, r), in
    deviations of the noise.
    """
    measured = best.problem.objective.grid.weight > 0.0
    step = best.covariance @ (best.linearisation.jacobian.T @ errors[measured])
    return largest(step / np.sqrt(np.maximum(np.diagonal(best.covariance), TINY)))


@dataclass(frozen=True, eq=False)
class Answer:
    """The point z (d,) with which a window was answered, and the integration error there.

    `error` is the largest at any output, in deviations of the noise, and `moved` that of any
    unknown, in its own; `tolerated` is what they may be: of an answer that leaves more than noise,
    more. z is None where there is no answer.
    """

    objective: Objective
    z: Array | None
    error: float = 0.0
    moved: float = 0.0
    tolerated: float = STEPPING.tolerated

    @classmethod
    def of(
        cls,
        window: WindowState,
        z: Array,
        best: Hypothesis | None = None,
        noise: Array | None = None,
    ) -> 'Answer':
        """Return the answer that was found for a window: z (d,), or the best hypothesis.

        `noise` (r,) is what is known of it in the end, if not the window's scale.
        """
        objective = window.objective if best is None else best.problem.objective
        noise = (
            noise_of(window) if noise is None else np.maximum(noise, least_noise(objective.grid))
        )
        if best is None:
            errors = in_deviations(errors_at(objective, z), objective.grid, noise)
            return cls(objective, z, largest(errors))
        residuals = best.trajectory[1]
        counts, squares = squares_of(residuals)
        left = np.sqrt(squares.sum() / counts.sum()) if counts.any() else 1.0
        errors = errors_at(best.problem, best.point, best.trajectory)
        errors = in_deviations(errors, objective.grid, noise)
        z, tolerated = best.point[best.final], STEPPING.tolerated * max(1.0, float(left))
        return cls(objective, z, largest(errors), moved(best, errors), tolerated)

    @property
    def counted(self) -> float:
        """What its errors count for in the choice of steps; see `counted_together`."""
        return counted_together(self.error, self.moved)

    @property
    def fine(self) -> bool:
        """Whether the answer need not be found anew in finer steps."""
        return self.z is None or max(self.error, self.moved) <= self.tolerated

    def told(self, estimate: Estimate) -> Estimate:
        """Return the estimate with the integration error, and the steps, among its figures.

        Where the error is more than tolerated, deviations are withheld: they count noise alone.
        """
        if self.z is None or self.objective.unknowns.model.period is not None:
            return estimate
        steps, method = self.objective.grid.steps, self.objective.kernels.model.method
        figures = {
            **estimate.figures,
            'integration_error_sd': self.error,
            f'integration_steps.{method}': float(steps.mean()),
        }
        estimate = replace(estimate, figures=figures)
        if self.fine:
            return estimate
        outcome = Outcome.APPROXIMATE if estimate.outcome in SOUND else estimate.outcome
        err = f'err by {self.error:.2g} standard deviations of the noise'
        if self.error <= self.tolerated:
            err = f'move an estimate by {self.moved:.2g} of its standard deviations'
        said = (
            'shorten the window, or smooth what switches in the model: '
            f'{steps.sum()} integration steps through the window still {err}, so no deviations are '
            'told'
        )
        return replace(
            estimate.without_deviations(), outcome=outcome, message=f'{said}; {estimate.message}'
        )
