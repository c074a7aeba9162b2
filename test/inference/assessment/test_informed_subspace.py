"""Tests of obs_ros.inference.assessment.informed_subspace."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from plants import INTEGRATOR, integrator_design, square_wave, window_of

from obs_ros import Model, Record, Variable
from obs_ros.core.deadline import Deadline
from obs_ros.core.prior_knowledge import with_knowledge
from obs_ros.core.typing import Array
from obs_ros.inference.assessment.informed_subspace import (
    informed_information,
    marginal_information,
)
from obs_ros.inference.jumps.hypothesis import Hypothesis, hypothesis_at
from obs_ros.inference.jumps.piecewise import PiecewiseProblem
from obs_ros.inference.parameterisation import Unknowns
from obs_ros.inference.prior import Prior
from obs_ros.optimization.levenberg_marquardt import levenberg_marquardt

T = 0.1 * np.arange(101)
SIGMA = 0.02

# The second rate shows only where the second level is not at rest.
DECAYS = Model(
    name='decays',
    states=(Variable('a', lower=-2.0, upper=2.0), Variable('b', lower=-2.0, upper=2.0)),
    outputs=(Variable('ya'), Variable('yb')),
    parameters=(Variable('pa', lower=0.1, upper=1.1), Variable('pb', lower=0.1, upper=1.1)),
    dynamics=lambda t, x, u, p: (-p[0] * x[0], -p[1] * x[1]),
    output=lambda t, x, u, p: (x[0], x[1]),
    max_step=0.1,
)


def fitted(
    a: float, b: float, seed: int = 0, backend: Any = 'numpy', **settings: Any
) -> Hypothesis:
    y = np.column_stack([a * np.exp(-0.5 * T), b * np.exp(-0.7 * T)])
    y += SIGMA * np.random.default_rng([seed, 6]).standard_normal(y.shape)
    objective = window_of(DECAYS, Record(T, None, y), SIGMA, backend, **settings)
    problem = PiecewiseProblem(objective, Prior.box(objective.unknowns))
    start = objective.unknowns.point({'a': a, 'b': b, 'pa': 0.5, 'pb': 0.7})
    found = levenberg_marquardt(problem, start[None], T.size, 60, Deadline())
    return hypothesis_at(problem, found.z[0])


def test_of_a_parameter_at_rest_nothing_is_said() -> None:
    """Whatever noise does to the initial state, seeds 0 to 19."""
    for seed in range(20):
        best = fitted(1.0, 0.0, seed)
        information = informed_information(best)
        assert information[0, 0] == pytest.approx(marginal_information(best, 2)[0, 0], rel=0.05)
        assert information[0, 0] > 1e3
        assert abs(information[1, 1]) < 1.0
        np.testing.assert_array_equal(information, information.T)
        # No precision in any direction is below 0, but for rounding.
        assert np.linalg.eigvalsh(information)[0] > -1e-9 * information[0, 0]


def test_noise_alone_would_feign_information() -> None:
    """Of that parameter the linearisation says more than nothing in most windows."""
    feigned = [marginal_information(fitted(1.0, 0.0, seed), 2)[1, 1] for seed in range(20)]
    left = [informed_information(fitted(1.0, 0.0, seed))[1, 1] for seed in range(20)]
    assert np.median(feigned) > 10.0 * np.median(np.abs(left))


def test_what_moves_is_let_through(backend: str) -> None:
    for seed in range(20 if backend == 'numba' else 3):
        best = fitted(1.0, 1.0, seed, backend)
        information = informed_information(best)
        jx, jp = best.linearisation.jacobian[:, :2], best.linearisation.jacobian[:, 2:]
        # The Schur complement of states that are all but free.
        apart = jp - jx @ np.linalg.solve(jx.T @ jx + 0.01 * np.eye(2), jx.T @ jp)
        np.testing.assert_allclose(information, jp.T @ apart, rtol=1e-9)
        np.testing.assert_allclose(information, marginal_information(best, 2), rtol=1e-9)


def test_nothing_moves_and_nothing_is_told() -> None:
    np.testing.assert_allclose(informed_information(fitted(0.0, 0.0)), 0.0, atol=1e-6)


def test_a_plant_linear_in_its_unknowns_tells_all() -> None:
    """Noise in the initial state changes no influence."""
    u = square_wave(T)
    y = integrator_design(T, u) @ [1.0, 1.3, -0.4]
    objective = window_of(INTEGRATOR, Record(T, u, y), SIGMA)
    problem = PiecewiseProblem(objective, Prior.box(objective.unknowns))
    best = hypothesis_at(problem, objective.unknowns.point({'x': 1.0, 'gain': 1.3, 'drift': -0.4}))
    np.testing.assert_allclose(informed_information(best), marginal_information(best, 1), rtol=1e-9)


@pytest.mark.parametrize(
    ('settings', 'size'),
    [
        ({'fixed': {'a': 1.0, 'b': 0.0}}, 2),
        ({'parameters': [], 'fixed': {'pa': 0.5, 'pb': 0.7}}, 0),
    ],
)
def test_without_states_or_parameters_nothing_is_feigned(settings: Any, size: int) -> None:
    best = fitted(1.0, 0.0, **settings)
    information = informed_information(best)
    assert information.shape == (size, size)
    np.testing.assert_array_equal(information, marginal_information(best, 2 - size))


def test_marginal_information_against_the_inverse_of_the_covariance() -> None:
    best = fitted(1.0, 1.0)
    jacobian: Array = best.linearisation.jacobian
    full = np.linalg.inv(jacobian.T @ jacobian + np.diag([0.01, 0.01, 0.0, 0.0]))
    expected = np.linalg.inv(full[2:, 2:])
    np.testing.assert_allclose(marginal_information(best, 2), expected, rtol=1e-6)


def given(best: Hypothesis, **priors: tuple[float, float]) -> Hypothesis:
    unknowns = Unknowns.of(with_knowledge(DECAYS, None, priors))
    problem = replace(best.problem, prior=Prior.known(unknowns, start=True))
    found = levenberg_marquardt(problem, best.point[None], T.size, 60, Deadline())
    return hypothesis_at(problem, found.z[0])


def test_a_given_prior_is_information_and_no_noise() -> None:
    """At rest nothing is told of pb: the prior is all, be it narrow or wide."""
    for seed in range(5):
        narrow = given(fitted(1.0, 0.0, seed), pb=(0.5, 0.01))
        information = informed_information(narrow)
        assert information[1, 1] == pytest.approx(1e4, rel=0.1)
        assert information == pytest.approx(marginal_information(narrow, 2))
        wide = given(fitted(1.0, 0.0, seed), pb=(0.5, 0.28))
        information = informed_information(wide)
        assert information[1, 1] == pytest.approx(1.0 / 0.28**2 - 12.0, abs=0.01)
        assert information[0, 0] > 1e3


def test_of_initial_states_a_given_prior_leaves_more_to_the_parameters() -> None:
    best = fitted(1.0, 1.0)
    free, known = (
        marginal_information(given(best, pa=(0.4, 60.0), **more), 2)
        for more in ({}, {'a': (1.0, 1e-3)})
    )
    assert known[0, 0] > 1.5 * free[0, 0]
    assert known[1, 1] == pytest.approx(free[1, 1], rel=1e-3)
