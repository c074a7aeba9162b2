"""Tests of obs_ros.optimization.ga."""

import re
from typing import Any

import numpy as np
import pytest
from problems import decay_problem, ripples_problem

from obs_ros.core.deadline import Deadline
from obs_ros.optimization.acceptance import Acceptance
from obs_ros.optimization.ga import GASettings, ga_search
from obs_ros.optimization.levenberg_marquardt import levenberg_marquardt
from obs_ros.optimization.result import Found

NEVER = Deadline()


def run(problem: Any, seed: int = 1, **settings: Any) -> Found:
    return ga_search(problem, np.random.default_rng(seed), NEVER, GASettings(**settings))


@pytest.mark.parametrize('coding', ['base10', 'real'])
def test_it_spends_its_generations_and_keeps_its_elite_unevaluated(coding: Any) -> None:
    problem = decay_problem()
    run(problem, coding=coding, generations=7, polish=False)
    assert problem.evaluations == 100 + 7 * 95


@pytest.mark.parametrize('coding', ['base10', 'real'])
def test_more_generations_never_end_worse(coding: Any) -> None:
    costs = [run(ripples_problem(), coding=coding, generations=g, polish=False).cost
             for g in (0, 1, 2, 5, 10, 40)]  # fmt: skip
    assert costs == sorted(costs, reverse=True)
    assert costs[-1] < 0.5 * costs[0]


@pytest.mark.parametrize('coding', ['base10', 'real'])
@pytest.mark.parametrize('seed', range(3))
def test_polished_it_ends_at_the_optimum(coding: Any, seed: int) -> None:
    problem = decay_problem(seed=seed)
    best = levenberg_marquardt(problem, np.full((1, 3), 0.5), 200, 100, NEVER)
    found = run(problem, seed, coding=coding)
    assert found.cost - best.squares[0] < 0.41 * best.squares[0] / 197
    assert found.accepted is Acceptance.POLISHED
    assert found.converged
    rough = run(problem, seed, coding=coding, polish=False)
    assert rough.cost > found.cost
    assert not rough.accepted


def test_without_squares_there_is_nothing_to_polish() -> None:
    problem = decay_problem()
    problem.is_least_squares = False
    run(problem)
    assert problem.evaluations == 100 + 40 * 95


def test_points_are_multiples_of_the_last_digit() -> None:
    found = run(decay_problem(), digits=3, polish=False)
    np.testing.assert_allclose(1000.0 * found.z, np.rint(1000.0 * found.z), atol=1e-9)


@pytest.mark.parametrize(
    ('settings', 'message'),
    [
        ({'coding': 'base2'}, "unknown coding 'base2'"),
        ({'parents': 101}, 'parents 101 are more than the population of 100'),
        ({'elite': 100}, 'elite 100 leaves no room in the population of 100'),
        ({'elite': 0}, 'elite must be an integer >= 1, not 0'),
        ({'mutation': 0.0}, 'mutation probability 0.0 is outside (0, 1]'),
        ({'digits': 1}, 'digits must be an integer >= 2, not 1'),
        ({'polish': 'yes'}, "polish must be true or false, not 'yes'"),
    ],
)
def test_wrong_settings_are_named(settings: Any, message: str) -> None:
    with pytest.raises(ValueError, match=re.escape(message)):
        GASettings(**settings)
