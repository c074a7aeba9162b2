"""Forecast skill of a window: by how much its model foretells better than holding the last value.

Every part of the window but the first is forecast from the state at its beginning, the filtered one
where process noise is known, under the inputs that came. The parameters are those that the other
parts give, to first order (cross-validation by blocks; Hastie, Tibshirani & Friedman 2009, section
7.10): without part k, whose residuals and Jacobian are r_k and J_k, the optimum moves by

    dz = (J'J + P - J_k' J_k)^-1 J_k' r_k.

The skill is 1 - the mean over the outputs of MSE / MSE of hold (Murphy 1988): 1 is a perfect
forecast, 0 one that is no better than holding the last value.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from obs_ros.core.linear_algebra import scaled_inverse
from obs_ros.core.periods import shortest
from obs_ros.core.typing import Array, IntArray
from obs_ros.inference.jumps.hypothesis import Hypothesis
from obs_ros.inference.jumps.piecewise import PiecewiseProblem
from obs_ros.inference.noise import noise_guess
from obs_ros.integration.grid import Grid


@dataclass(frozen=True)
class SkillSettings:
    """Limits in judging forecasts.

    - `parts`: of a window, each the length of a forecast;
    - `convincing`: skill above which a model that process noise completes is no mere approximation:
      it foretells more than half of what holding the last value misses;
    - `most_noise`: times the noise that is given, beyond which a residual is no approximation.
    """

    parts: int = 8
    convincing: float = 0.5
    most_noise: float = 10.0


SKILL = SkillSettings()


@dataclass(frozen=True)
class Errors:
    """Sums of squared errors (P, r) of forecasts by parts, and of holding; their counts (P, r).

    noise (r,): deviations below which holding cannot come.
    """

    model: Array
    hold: Array
    count: Array
    noise: Array

    @property
    def skill(self) -> float:
        """See `skill_of`."""
        model, hold, count = (each.sum(axis=0) for each in (self.model, self.hold, self.count))
        return skill_of(model, hold, count, self.noise)

    @property
    def logs(self) -> Array:
        """Mean log MSE (P,) over the outputs, part by part, see `mean_log_errors`."""
        parts = zip(self.model, self.hold, self.count, strict=True)
        return np.array([mean_log_errors(m[None], h, c, self.noise)[0] for m, h, c in parts])


def forecast_skill(best: Hypothesis) -> float:
    """Return the skill of a hypothesis on its window; NaN if nothing can tell."""
    return forecast_errors(best).skill


def forecast_errors(
    best: Hypothesis, problem: PiecewiseProblem | None = None, settings: SkillSettings = SKILL
) -> Errors:
    """Return the errors of forecasts by a hypothesis; they know the jumps before them only.

    With a `problem` of the same layout the hypothesis gives the parameters alone, and that the
    states at the beginning of forecasts.
    """
    problem = problem or best.problem
    objective = problem.objective
    grid = objective.grid
    origins = _origins(grid, settings.parts)
    points = _without_parts(best, origins)
    beginnings = _beginnings(problem, points, origins[:-1])
    objective.counter.candidates += len(points)
    free = grid.uncorrected
    model, hold, count = (np.zeros((len(points), grid.scale.size)) for _ in range(3))
    for k, (first, last) in enumerate(pairwise(origins)):
        part = free.stretch(first, last)
        x0, p0 = beginnings[k]
        foretold = part.nearest(objective.kernels.trajectories(part, x0, p0)[1][:, :, 0])[1:]
        known, held = part.weight[1:] > 0.0, last_values(grid, first)
        y = part.y[1:]
        known &= np.isfinite(held)
        model[k] = np.sum((foretold - y) ** 2, axis=0, where=known)
        off = shortest(np.where(np.isfinite(held), held, 0.0) - y, grid.period)
        hold[k] = np.sum(off**2, axis=0, where=known)
        count[k] = known.sum(axis=0)
    return Errors(model, hold, count, least_noises(grid))


def skill_of(model: Array, hold: Array, count: Array, noise: Array) -> float:
    """Return the skill from sums as of `Errors`; NaN where nothing was counted.

    Holding the last value cannot foretell better than noise of deviation (r,) lets it, twice the
    variance: at rest the ratio is against that.
    """
    told = count > 0
    if not told.any():
        return float('nan')
    with np.errstate(all='ignore'):
        ratio = model[told] / np.maximum(hold[told], 2.0 * count[told] * noise[told] ** 2)
    ratio = np.where(np.isfinite(ratio), ratio, np.where(model[told] == 0.0, 0.0, np.inf))
    return float(1.0 - ratio.mean())


def mean_log_errors(models: Array, hold: Array, count: Array, noise: Array) -> Array:
    """Return mean log MSE (B,) over the outputs, of sums (B, r); others are as of `Errors`.

    Beyond holding the last value, all are of no use, and alike.
    """
    told = count > 0
    if not told.any():
        return np.zeros(len(models))
    counted = count[told]
    with np.errstate(all='ignore'):
        most = np.maximum(hold[told] / counted, 2.0 * noise[told] ** 2)
        mean = np.fmin(models[:, told] / counted, most)
    return np.asarray(np.log(mean + np.finfo(float).tiny).mean(axis=1))


def least_noises(grid: Grid) -> Array:
    """Return the noise (r,) of the outputs by their bends, whatever model or noise is assumed."""
    outputs = zip(grid.y.T, grid.weight.T, strict=True)
    return np.array([noise_guess(np.where(w > 0.0, y, np.nan), nothing=0.0) for y, w in outputs])


def last_values(grid: Grid, node: int) -> Array:
    """Return the last measured values (r,) at or before a node; NaN where there is none."""
    held = np.full(grid.scale.size, np.nan)
    for i, weight in enumerate(grid.weight[: node + 1].T):
        known = np.flatnonzero(weight)
        if known.size:
            held[i] = grid.y[known[-1], i]
    return held


def _beginnings(
    problem: PiecewiseProblem, points: Array, origins: IntArray
) -> list[tuple[Array, Array]]:
    """Return state (n, 1) and parameters (q, 1) of each point (D,) at an origin of its own."""
    objective, layout = problem.objective, problem.layout
    if layout.events:
        states = problem.roll(points)[0]
        times = (objective.grid.t - objective.grid.t[0]) / (
            objective.grid.t[-1] - objective.grid.t[0]
        )
        found = []
        for k, (point, origin) in enumerate(zip(points, origins, strict=True)):
            now = np.arange(layout.dimension)
            for jump in layout.jumped(point):
                if point[layout.times[jump.event]] <= times[origin]:
                    now[jump.parameter] = jump.after
            p = objective.unknowns.values(point[now][None])[1]
            found.append((np.ascontiguousarray(states[origin, :, k : k + 1]), p))
        return found
    x, p = objective.unknowns.values(points)
    states, moved, _ = objective.kernels.paths(objective.grid, x, p)
    objective.counter.candidates += len(points)
    return [
        (
            np.ascontiguousarray(states[origin, :, k : k + 1]),
            np.ascontiguousarray(moved[origin, :, k : k + 1]),
        )
        for k, origin in enumerate(origins)
    ]


def _origins(grid: Grid, parts: int) -> IntArray:
    """Return the nodes at which parts begin, from the second on, and the last node."""
    times = np.linspace(grid.t[0], grid.t[-1], parts + 1)[1:]
    return np.unique(np.clip(np.searchsorted(grid.t, times), 1, grid.t.size - 1))


def _without_parts(best: Hypothesis, origins: IntArray) -> Array:
    """Return the points (B, d) that the window gives without each part."""
    linearisation, objective = best.linearisation, best.problem.objective
    z, limits = best.point, best.problem.limits
    rows = np.nonzero(objective.grid.weight > 0.0)[0]
    J, r = linearisation.jacobian, linearisation.residual
    information = J.T @ J + best.problem.precision(z)
    free = (z > limits[0]) & (z < limits[1])
    free[best.layout.times] = False  # all points jump in the intervals of the first
    points = np.repeat(z[None], len(origins) - 1, axis=0)
    for k, (first, last) in enumerate(pairwise(origins)):
        part = (rows > first) & (rows <= last)
        J_k = J[part][:, free]
        left = information[np.ix_(free, free)] - J_k.T @ J_k
        points[k, free] += scaled_inverse(left) @ (J_k.T @ r[part])
    return np.clip(points, *limits)
