"""Tests of obs_ros.inference.assessment.output_error."""

import numpy as np
import pytest
from plants import window_of

from obs_ros import Model, Record, Variable
from obs_ros.core.deadline import Deadline
from obs_ros.core.typing import Array
from obs_ros.inference.assessment.output_error import output_error_covariance
from obs_ros.inference.disturbed import filtered
from obs_ros.inference.jumps.hypothesis import Hypothesis, hypothesis_at
from obs_ros.inference.jumps.piecewise import PiecewiseProblem
from obs_ros.inference.prior import Posterior, Prior
from obs_ros.inference.process_noise import ProcessNoise
from obs_ros.inference.window_state import WindowState
from obs_ros.optimization.levenberg_marquardt import levenberg_marquardt

WALK, SIGMA, INTERVAL, NODES = 0.1, 0.02, 0.1, 300
T = INTERVAL * np.arange(NODES)
U = np.where((T // 4.0) % 2 == 0, 1.0, -1.0)

# x' = -x + k u, so that all is linear in x(0) and k.
LINEAR = Model(
    name='linear_in_its_gain',
    states=(Variable('x', lower=-5.0, upper=5.0),),
    inputs=(Variable('u'),),
    outputs=(Variable('y'),),
    parameters=(Variable('k', lower=0.0, upper=4.0),),
    dynamics=lambda t, x, u, p: (p[0] * u[0] - x[0],),
    output=lambda t, x, u, p: (x[0],),
)


def simulated(seed: int) -> Array:
    rng, hold = np.random.default_rng([seed, 6]), np.exp(-INTERVAL)
    spread = WALK * np.sqrt((1.0 - hold**2) / 2.0)
    x = np.empty(NODES)
    x[0] = 0.3
    for k in range(NODES - 1):
        x[k + 1] = 1.2 * U[k] + (x[k] - 1.2 * U[k]) * hold + spread * rng.standard_normal()
    return x + SIGMA * rng.standard_normal(NODES)


def fitted(y: Array) -> tuple[WindowState, Hypothesis]:
    record = Record(T, U, y)
    objective = window_of(LINEAR, record, SIGMA, backend=None)
    prior = Prior.box(objective.unknowns)
    start = objective.unknowns.point({'x': 0.3, 'k': 1.2})
    solved = levenberg_marquardt(Posterior(objective, prior), start[None], NODES, 40, Deadline())
    window = WindowState(record, objective, prior, noise_known=True)
    return window, hypothesis_at(PiecewiseProblem(objective, prior), solved.z[0])


def test_deviations_are_those_that_estimates_of_pushed_plants_have() -> None:
    noise = ProcessNoise(np.array([WALK, 0.0]), np.array([SIGMA]))
    points, told, naive = [], [], []
    for seed in range(200):
        window, plain = fitted(simulated(seed))
        along = filtered(window, plain.point, noise)
        points.append(plain.point)
        told.append(np.diagonal(output_error_covariance(plain, noise, along)))
        naive.append(np.diagonal(plain.covariance))
    scatter, told = np.std(points, axis=0), np.sqrt(np.mean(told, axis=0))
    # 200 windows tell a deviation to 5 %.
    np.testing.assert_allclose(told, scatter, rtol=0.15)
    assert (scatter > 3.0 * np.sqrt(np.mean(naive, axis=0))).all()


def test_without_walks_they_are_those_of_output_error() -> None:
    window, plain = fitted(simulated(0))
    noise = ProcessNoise(np.zeros(2), np.array([SIGMA]))
    found = output_error_covariance(plain, noise, filtered(window, plain.point, noise))
    np.testing.assert_allclose(found, plain.covariance, rtol=1e-6)


def test_values_that_were_not_measured_say_nothing() -> None:
    y = simulated(1)
    y[1::2] = np.nan
    window, plain = fitted(y)
    noise = ProcessNoise(np.zeros(2), np.array([SIGMA]))
    found = output_error_covariance(plain, noise, filtered(window, plain.point, noise))
    assert found == pytest.approx(plain.covariance, rel=1e-6)
