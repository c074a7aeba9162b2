"""Tests of obs_ros.inference.assessment.skill."""

from itertools import pairwise

import numpy as np
import pytest
from plants import LAG, lag_outputs, square_wave, window_of

from obs_ros import Record
from obs_ros.core.deadline import Deadline
from obs_ros.core.typing import Array
from obs_ros.inference.assessment.skill import (
    SKILL,
    forecast_skill,
    last_values,
    least_noises,
    skill_of,
)
from obs_ros.inference.jumps.hypothesis import Hypothesis, hypothesis_at
from obs_ros.inference.jumps.piecewise import PiecewiseProblem
from obs_ros.inference.prior import Posterior, Prior
from obs_ros.optimization.levenberg_marquardt import levenberg_marquardt

SIGMA, INTERVAL, NODES = 0.02, 0.1, 400
T = INTERVAL * np.arange(NODES)
U = square_wave(T)


def fitted(y: Array, u: Array = U) -> Hypothesis:
    objective = window_of(LAG, Record(T, u, y), SIGMA, backend=None)
    prior = Prior.box(objective.unknowns)
    start = objective.unknowns.point({'x': y[0, 0], 'k': 1.2, 'tau': 3.0})
    solved = levenberg_marquardt(Posterior(objective, prior), start[None], NODES, 60, Deadline())
    return hypothesis_at(PiecewiseProblem(objective, prior), solved.z[0])


def outputs(seed: int = 0) -> Array:
    noise = SIGMA * np.random.default_rng(seed).standard_normal((NODES, 1))
    return lag_outputs(T, U, 1.0, np.tile([1.2, 3.0], (NODES, 1))).reshape(-1, 1) + noise


def test_the_right_model_foretells_up_to_the_noise() -> None:
    y = outputs()
    skill = forecast_skill(fitted(y))
    origins = np.searchsorted(T, np.linspace(0.0, T[-1], SKILL.parts + 1)[1:])
    hold = [(y[a + 1 : b + 1] - y[a]) ** 2 for a, b in pairwise(origins)]
    assert skill == pytest.approx(1.0 - SIGMA**2 / np.concatenate(hold).mean(), abs=0.01)


def test_outputs_that_inputs_do_not_move_are_foretold_no_better_than_by_holding() -> None:
    walk = np.cumsum(np.random.default_rng(3).standard_normal((NODES, 1)), axis=0)
    assert forecast_skill(fitted(0.3 * walk)) < 0.0


def test_at_rest_forecasts_miss_by_the_noise_and_holding_by_twice_its_variance() -> None:
    skills = []
    for seed in range(20):
        y = SIGMA * np.random.default_rng([seed, 5]).standard_normal((NODES, 1))
        skills.append(forecast_skill(fitted(y, np.zeros_like(U))))
    assert np.mean(skills) == pytest.approx(0.5, abs=0.1)
    assert max(skills) < 0.75


def test_at_rest_a_forecast_as_good_as_the_noise_beats_holding() -> None:
    squares = np.array([100.0])
    assert skill_of(squares, np.array([50.0]), np.array([100.0]), np.array([1.0])) == 0.5
    assert skill_of(squares, np.array([400.0]), np.array([100.0]), np.array([1.0])) == 0.75


def test_an_output_that_was_never_measured_does_not_count() -> None:
    found = skill_of(
        np.array([1.0, 0.0]), np.array([4.0, 0.0]), np.array([9.0, 0.0]), np.array([0.1, 0.1])
    )
    assert found == 0.75
    nothing = np.zeros(1)
    assert np.isnan(skill_of(nothing, nothing, nothing, np.ones(1)))


def test_a_forecast_that_diverges_has_no_skill_at_all() -> None:
    assert skill_of(np.array([np.inf]), np.ones(1), np.ones(1), np.ones(1)) == -np.inf
    assert skill_of(np.array([np.nan]), np.ones(1), np.ones(1), np.ones(1)) == -np.inf


def test_a_forecast_knows_the_jumps_before_it_only() -> None:
    p = np.where(T[:, None] < 20.5, [1.2, 3.0], [2.4, 3.0])
    noise = SIGMA * np.random.default_rng(1).standard_normal((NODES, 1))
    y = lag_outputs(T, U, 1.0, p).reshape(-1, 1) + noise
    best = fitted(y)
    problem = PiecewiseProblem(best.problem.objective, best.problem.prior, ((1,),))
    unknowns = best.problem.objective.unknowns
    before = unknowns.point({'x': 1.0, 'k': 1.2, 'tau': 3.0})
    after = unknowns.point({'x': 1.0, 'k': 2.4, 'tau': 3.0})[1]
    jumped = hypothesis_at(problem, np.array([*before, 20.5 / T[-1], after]))
    # One of seven parts meets the jump unprepared.
    assert forecast_skill(best) < forecast_skill(jumped) < 0.99


def test_the_last_values_are_those_measured_last() -> None:
    y = outputs()
    y[5:8] = np.nan
    grid = window_of(LAG, Record(T, U, y), SIGMA).grid
    assert last_values(grid, 7) == y[4]
    y[:] = np.nan
    y[9] = 1.0
    assert np.isnan(last_values(window_of(LAG, Record(T, U, y), SIGMA).grid, 8)).all()


def test_the_least_noise_is_that_of_the_bends() -> None:
    grid = window_of(LAG, Record(T, U, outputs()), 7.0).grid
    assert least_noises(grid) == pytest.approx(SIGMA, rel=0.15)
