"""Tests of obs_ros.horizon.integration_error."""

from dataclasses import replace

import numpy as np
import pytest
from stiff_plants import integration_error, measured, truth, van_der_pol

from obs_ros.core.deadline import Deadline
from obs_ros.core.estimate import Outcome
from obs_ros.core.rng import random_generator
from obs_ros.core.typing import Array
from obs_ros.horizon.integration_error import (
    FLOOR,
    Answer,
    error_at,
    errors_at,
    least_noise,
    moved,
    noise_of,
)
from obs_ros.horizon.settings import EstimationSettings
from obs_ros.horizon.solver import Solver
from obs_ros.inference.jumps.hypothesis import hypothesis_at
from obs_ros.inference.jumps.piecewise import PiecewiseProblem
from obs_ros.inference.prior import Prior
from obs_ros.inference.window_state import WindowState
from obs_ros.optimization.levenberg_marquardt import levenberg_marquardt

MODEL = van_der_pol(1.0)
T = 0.1 * np.arange(100)
U = np.empty((100, 0))
RECORD, NOISE = measured(MODEL, T, U, (2.0, 0.0), (1.2,), by='DOP853')
SOLVER = Solver.of(MODEL, EstimationSettings(noise=NOISE, backend='numpy', process_noise='off'))
WINDOW = SOLVER.pose(RECORD, prior=Prior.box(SOLVER.unknowns), noise_known=True)
Z = SOLVER.unknowns.point({'x': 2.0, 'rate': 0.0, 'mu': 1.2})


def stepped(steps: int) -> WindowState:
    objective = WINDOW.objective
    grid = objective.grid.stepped(steps * objective.grid.steps)
    return replace(WINDOW, objective=replace(objective, grid=grid))


def test_the_error_falls_with_the_fourth_power_of_the_steps() -> None:
    noise = noise_of(WINDOW)
    errors = [error_at(stepped(n).objective, Z, noise) for n in (1, 2, 4)]
    assert errors[0] / errors[1] == pytest.approx(16.0, rel=0.3)
    assert errors[1] / errors[2] == pytest.approx(16.0, rel=0.3)
    problem = PiecewiseProblem(WINDOW.objective, WINDOW.prior)
    assert error_at(problem, Z, noise) == errors[0]
    assert error_at(problem, Z, 10.0 * noise) == pytest.approx(0.1 * errors[0])
    # All of them together move an unknown by the root of the sum of their squares at most.
    every = np.abs(errors_at(problem, Z)) * (WINDOW.objective.grid.scale / noise)
    assert every.shape == (100, 1)
    assert errors[0] == pytest.approx(max(every.max(), 0.2 * np.sqrt(np.sum(every**2))))


def test_what_moves_is_where_finer_steps_lead() -> None:
    """One step of max_step: the optimum of four times as many is `moved` deviations away."""
    coarse, fine = (
        hypothesis_at(PiecewiseProblem(each.objective, each.prior), optimum(each))
        for each in (WINDOW, stepped(4))
    )
    off = (fine.point - coarse.point) / np.sqrt(np.diagonal(coarse.covariance))
    errors = errors_at(coarse.problem, coarse.point, coarse.trajectory)
    assert moved(coarse, errors) == pytest.approx(np.abs(off).max(), rel=0.2)
    answer = Answer.of(WINDOW, coarse.point, coarse)
    assert answer.moved == moved(coarse, errors)
    assert answer.counted == max(answer.error, 0.2 * answer.moved)


def optimum(window: WindowState) -> Array:
    problem = window.with_given_priors
    found = levenberg_marquardt(problem, Z[None], window.objective.nodes, 100, Deadline())
    return np.asarray(found.z[0])


def test_the_noise_is_what_is_left_where_that_is_more_or_nothing_is_known() -> None:
    scale = WINDOW.objective.grid.scale
    np.testing.assert_array_equal(noise_of(WINDOW), scale)
    twice = np.full((100, 1), 2.0)
    np.testing.assert_allclose(noise_of(WINDOW, twice), 2.0 * scale)
    np.testing.assert_array_equal(noise_of(WINDOW, 0.1 * twice), scale)
    unknown = replace(WINDOW, noise_known=False)
    np.testing.assert_allclose(noise_of(unknown, 0.1 * twice), 0.2 * scale)
    # Below 100 dB it is not believed.
    deviation = RECORD.y.std(axis=0)
    np.testing.assert_allclose(least_noise(WINDOW.objective.grid), FLOOR.share * deviation)
    np.testing.assert_allclose(noise_of(unknown, 1e-9 * twice), FLOOR.share * deviation)


def test_an_answer_tells_its_error_and_withholds_deviations_where_that_is_large() -> None:
    estimate = SOLVER.solve(RECORD, random_generator(1), Deadline())
    assert estimate.figures['integration_error_sd'] == pytest.approx(
        integration_error(MODEL, estimate, U, NOISE, by='DOP853'), rel=0.2, abs=0.01
    )
    fine = Answer(WINDOW.objective, Z, error=0.2)
    assert fine.fine and fine.told(estimate).stddev == estimate.stddev
    bad = Answer(WINDOW.objective, Z, error=0.4).told(estimate)
    assert bad.outcome is Outcome.APPROXIMATE and bad.parameters == estimate.parameters
    assert np.isnan(bad.stddev['mu']) and bad.figures['integration_error_sd'] == 0.4
    assert bad.message.startswith('shorten the window, or smooth what switches in the model: 99 ')
    assert 'err by 0.4 standard deviations of the noise' in bad.message
    off = Answer(WINDOW.objective, Z, error=0.2, moved=0.5).told(estimate)
    assert off.outcome is Outcome.APPROXIMATE and np.isnan(off.stddev['mu'])
    assert 'move an estimate by 0.5 of its standard deviations' in off.message
    left = Answer(WINDOW.objective, Z, error=0.4, moved=0.5, tolerated=0.6)
    assert left.fine and left.told(estimate).stddev == estimate.stddev
    assert Answer(WINDOW.objective, None).told(estimate) is estimate


def test_an_answer_far_from_the_measurements_may_err_in_proportion() -> None:
    off = SOLVER.unknowns.point({'x': 1.0, 'rate': 0.0, 'mu': 1.2})
    answer = Answer.of(WINDOW, off)
    assert answer.tolerated == 0.3


def test_own_steps_err_in_proportion_to_their_tolerance() -> None:
    """Van der Pol's equation, mu = 100: the error told is that beside scipy's LSODA."""
    model = replace(van_der_pol(100.0), integrator='rosenbrock')
    t, start = np.linspace(0.0, 120.0, 51), (1.5, -1.5 / 125.0)
    record, noise = measured(model, t, np.empty((51, 0)), start, (100.0,), share=1e-4)
    solver = Solver.of(model, EstimationSettings(noise=noise, process_noise='off'))
    window = solver.pose(record, prior=Prior.box(solver.unknowns), noise_known=True)
    z = solver.unknowns.point({'x': start[0], 'rate': start[1], 'mu': 100.0})
    exact = truth(model, t, np.empty((51, 0)), start, (100.0,))
    for tolerance in (1e-4, 1e-6):
        grid = replace(window.objective.grid, tolerance=tolerance, budget=20_000)
        objective = replace(window.objective, grid=grid)
        residuals = objective.trajectory(z)[1]
        off = grid.y + residuals / grid.weight - exact
        error = error_at(objective, z, noise_of(window))
        assert error == pytest.approx(np.abs(off).max() / noise['x'], rel=0.5)
    assert error < 1.0
