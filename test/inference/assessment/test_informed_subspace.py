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
    SUBSPACE,
    InformedSubspace,
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


def test_a_parameter_at_rest_is_held() -> None:
    """Whatever noise does to the initial state, seeds 0 to 19."""
    for seed in range(20):
        gate = InformedSubspace.of(fitted(1.0, 0.0, seed))
        assert len(gate.held) == 1
        direction = gate.held[0] / np.linalg.norm(gate.held[0])
        assert abs(direction[1]) > 0.999
        np.testing.assert_allclose(gate.informed, np.diag([1.0, 0.0]), atol=0.02)
        assert gate.information[0, 0] > 1e3
        assert abs(gate.information[1, 1]) < 1.0


def test_what_moves_is_let_through(backend: str) -> None:
    for seed in range(20 if backend == 'numba' else 3):
        best = fitted(1.0, 1.0, seed, backend)
        gate = InformedSubspace.of(best)
        assert gate.held.shape == (0, 2)
        np.testing.assert_array_equal(gate.informed, np.eye(2))
        jx, jp = best.linearisation.jacobian[:, :2], best.linearisation.jacobian[:, 2:]
        # The Schur complement of states that are all but free.
        apart = jp - jx @ np.linalg.solve(jx.T @ jx + 0.01 * np.eye(2), jx.T @ jp)
        np.testing.assert_allclose(gate.information, jp.T @ apart, rtol=1e-9)
        np.testing.assert_allclose(gate.information, marginal_information(best, 2), rtol=1e-9)
        np.testing.assert_allclose(gate.covariance(best), best.covariance, rtol=1e-6)


def test_nothing_moves_and_nothing_is_told() -> None:
    gate = InformedSubspace.of(fitted(0.0, 0.0))
    assert gate.held.shape == (2, 2)
    np.testing.assert_allclose(gate.informed, 0.0, atol=1e-9)


def test_a_held_direction_stays_where_the_prior_has_it() -> None:
    best = fitted(1.0, 0.0, 3)
    gate, prior = InformedSubspace.of(best), best.problem.prior
    held = gate.holding(prior)
    form = gate.held[0] / np.linalg.norm(gate.held[0])
    along = np.concatenate([[0.0, 0.0], form])
    assert along @ held.precision @ along == pytest.approx(SUBSPACE.hold, rel=1e-6)
    across = np.concatenate([[0.0, 0.0], [form[1], -form[0]]])
    assert across @ held.precision @ across == pytest.approx(12.0)
    problem = replace(best.problem, prior=held)
    found = levenberg_marquardt(problem, best.point[None], T.size, 60, Deadline()).z[0]
    assert (found[2:] - prior.mean[2:]) @ form == pytest.approx(0.0, abs=1e-6)
    assert found[2] == pytest.approx(0.4, abs=0.1)  # what is told is as it was: 0.5 in its box
    np.testing.assert_array_equal(held.mean, prior.mean)


def test_of_a_held_direction_only_the_prior_knows() -> None:
    best = fitted(1.0, 0.0, 3)
    gate = InformedSubspace.of(best)
    covariance = gate.covariance(best)
    assert covariance[3, 3] == pytest.approx(1.0 / 12.0, rel=0.01)
    assert covariance[2, 2] == pytest.approx(best.covariance[2, 2], rel=0.05)


def test_a_plant_linear_in_its_unknowns_holds_nothing() -> None:
    """Noise in the initial state changes no influence."""
    u = square_wave(T)
    y = integrator_design(T, u) @ [1.0, 1.3, -0.4]
    objective = window_of(INTEGRATOR, Record(T, u, y), SIGMA)
    problem = PiecewiseProblem(objective, Prior.box(objective.unknowns))
    best = hypothesis_at(problem, objective.unknowns.point({'x': 1.0, 'gain': 1.3, 'drift': -0.4}))
    assert InformedSubspace.of(best).held.shape == (0, 2)


@pytest.mark.parametrize(
    ('settings', 'size'),
    [
        ({'fixed': {'a': 1.0, 'b': 0.0}}, 2),
        ({'parameters': [], 'fixed': {'pa': 0.5, 'pb': 0.7}}, 0),
    ],
)
def test_without_states_or_parameters_there_is_nothing_to_hold(settings: Any, size: int) -> None:
    best = fitted(1.0, 0.0, **settings)
    gate = InformedSubspace.of(best)
    assert gate.held.shape == (0, size)
    assert gate.information.shape == (size, size)
    assert np.isfinite(gate.covariance(best)).all()


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
    """At rest nothing is told of pb: a narrow prior is all, a wide one holds it."""
    for seed in range(5):
        narrow = given(fitted(1.0, 0.0, seed), pb=(0.5, 0.01))
        gate = InformedSubspace.of(narrow)
        assert not len(gate.held)
        assert gate.information[1, 1] == pytest.approx(1e4, rel=0.1)
        assert gate.covariance(narrow)[3, 3] == pytest.approx(1e-4, rel=0.1)
        assert gate.information == pytest.approx(marginal_information(narrow, 2))
        wide = given(fitted(1.0, 0.0, seed), pb=(0.5, 0.28))
        gate = InformedSubspace.of(wide)
        assert len(gate.held) == 1
        assert gate.information[1, 1] == pytest.approx(1.0 / 0.28**2 - 12.0, abs=0.01)
        assert gate.covariance(wide)[3, 3] == pytest.approx(0.28**2, rel=1e-3)


def test_where_priors_are_given_held_directions_move_as_these_let_them() -> None:
    best = given(fitted(1.0, 0.0, 3), pb=(0.5, 0.28))
    gate, precision = InformedSubspace.of(best), best.problem.prior.precision[2:, 2:]
    # The direction that stays: the informed projection sends it to 0.
    values, vectors = np.linalg.eig(gate.informed)
    direction = np.real(vectors[:, np.argmin(np.abs(values))])
    expected = precision @ direction
    found = gate.held[0]
    np.testing.assert_allclose(np.outer(found, expected), np.outer(expected, found), atol=1e-9)


def test_of_initial_states_a_given_prior_leaves_more_to_the_parameters() -> None:
    best = fitted(1.0, 1.0)
    free, known = (
        marginal_information(given(best, pa=(0.4, 60.0), **more), 2)
        for more in ({}, {'a': (1.0, 1e-3)})
    )
    assert known[0, 0] > 1.5 * free[0, 0]
    assert known[1, 1] == pytest.approx(free[1, 1], rel=1e-3)
