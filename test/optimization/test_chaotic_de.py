"""Tests of obs_ros.optimization.chaotic_de."""

import numpy as np
from problems import decay_problem

from obs_ros.core.deadline import Deadline
from obs_ros.optimization.chaotic_de import ChaoticDESettings, chaotic_de_search


def test_the_papers_constants() -> None:
    s = ChaoticDESettings()
    assert (s.population, s.generations, s.differential_weight, s.crossover) == (25, 85, 0.7, 0.7)
    assert (s.chaos, s.strategy) == ('cubic', 'rand/1/bin')


def test_it_spends_its_generations_and_no_more() -> None:
    problem = decay_problem()
    chaotic_de_search(problem, np.random.default_rng(1), Deadline(), ChaoticDESettings())
    assert problem.evaluations == 25 * 86


def test_without_time_it_evaluates_its_first_population() -> None:
    problem = decay_problem()
    chaotic_de_search(problem, np.random.default_rng(1), Deadline(0.0), ChaoticDESettings())
    assert problem.evaluations == 25


def test_it_says_whether_its_population_has_gathered() -> None:
    short = chaotic_de_search(
        decay_problem(), np.random.default_rng(2), Deadline(), ChaoticDESettings()
    )
    assert not short.accepted
    long = chaotic_de_search(
        decay_problem(), np.random.default_rng(2), Deadline(), ChaoticDESettings(generations=400)
    )
    assert long.accepted == 'the population has gathered in one point'
    assert long.converged
