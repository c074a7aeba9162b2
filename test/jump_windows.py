"""Windows of the integrator in which a parameter jumps, whose evidence is known in closed form."""

from dataclasses import replace

import numpy as np
from plants import INTEGRATOR, integrator_design, square_wave, window_of
from scipy.stats import multivariate_normal

from obs_ros import Model, Record
from obs_ros.core.deadline import Deadline
from obs_ros.core.typing import Array
from obs_ros.inference.jumps.hypothesis import Hypothesis, hypothesis_at
from obs_ros.inference.jumps.piecewise import PiecewiseProblem
from obs_ros.inference.prior import Prior
from obs_ros.optimization.levenberg_marquardt import levenberg_marquardt

T = 0.1 * np.arange(101)
U = square_wave(T, 1.7)
SIGMA = 0.1
WIDTH, LOWER = np.array([20.0, 2.0, 2.0]), np.array([-10.0, 0.0, -1.0])
DESIGN = integrator_design(T, U) * WIDTH / SIGMA  # (K, 3), in boxes
GAIN, DRIFT = 1, 2


def changed(time: float, place: int) -> Array:
    """What a jump of a parameter by one box at `time` (s) does to y (K,), in units of noise."""
    fine = np.concatenate([[time], T[time < T]])
    rate = U[np.searchsorted(T, time, side='right') - 1 :] if place == GAIN else 1.0
    steps = np.diff(fine) * (rate[: fine.size - 1] if place == GAIN else 1.0)
    y = np.zeros(T.size)
    y[time < T] = np.cumsum(steps)
    return y * WIDTH[place] / SIGMA


def record(jump: float = 0.0, time: float = 4.23, seed: int = 1) -> Record:
    y = integrator_design(T, U) @ [1.0, 1.3, -0.4] + jump * changed(time, DRIFT) * SIGMA / 2.0
    return Record(T, U, y + SIGMA * np.random.default_rng(seed).standard_normal(T.size))


def still(window: Record, prior: Prior | None = None, model: Model = INTEGRATOR) -> Hypothesis:
    """The best hypothesis without a jump."""
    objective = window_of(model, window, SIGMA, backend=None)
    prior = prior or Prior.box(objective.unknowns)
    return solved(PiecewiseProblem(objective, prior), np.full(3, 0.5))


def solved(problem: PiecewiseProblem, start: Array) -> Hypothesis:
    point = levenberg_marquardt(problem, start[None], T.size, 40, Deadline()).z
    for _ in range(2):  # to the last digit
        _, gradient, hessian = problem.linearise(point, np.full_like(point, 1e-7), T.size)
        point = point - np.linalg.solve(hessian[0], gradient[0])
    return hypothesis_at(problem, point[0])


def with_a_drift_jump(window: Record, prior: Prior | None = None) -> Hypothesis:
    """The best hypothesis that the drift jumped about when it did in `record`."""
    problem = replace(still(window, prior).problem, events=((DRIFT,),))
    return solved(problem, np.array([0.55, 0.65, 0.3, 0.43, 0.6]))


def neg2_log_probability(window: Record, *shapes: Array, prior: Prior | None = None) -> float:
    """-2 ln of the probability of a window's samples, in closed form, jumps by box variance."""
    mean = prior.mean if prior else np.full(3, 0.5)
    covariance = np.linalg.inv(prior.precision) if prior else np.diag([100.0, 1 / 12, 1 / 12])
    target = (window.y[:, 0] - integrator_design(T, U) @ LOWER) / SIGMA
    spread = np.eye(T.size) + DESIGN @ covariance @ DESIGN.T
    for shape in shapes:
        spread += np.outer(shape, shape) / 12.0
    return -2.0 * float(multivariate_normal(DESIGN @ mean, spread).logpdf(target))


TIGHT = Prior.of(
    window_of(INTEGRATOR, record(), SIGMA).unknowns,
    np.array([0.64, 0.31]),
    np.array([[4e-4, 1e-4], [1e-4, 9e-4]]),
)
