"""Tests of obs_ros.horizon.alone."""

import numpy as np
from plants import LAG, lag_outputs, square_wave

from obs_ros import Record
from obs_ros.core.deadline import Deadline
from obs_ros.core.rng import random_generator
from obs_ros.horizon.alone import best_alone, explained_alone
from obs_ros.horizon.settings import EstimationSettings
from obs_ros.horizon.solver import Solver
from obs_ros.inference.prior import Prior

T = 0.1 * np.arange(200)
U = square_wave(T)
NOISE = 0.05 * np.random.default_rng(1).standard_normal(200)
RECORD = Record(T, U, lag_outputs(T, U, 0.5, np.tile([1.2, 3.0], (199, 1))) + NOISE)
SOLVER = Solver.of(LAG, EstimationSettings(process_noise='off'))
NOTHING = np.array([np.nan])


def test_a_window_by_itself_has_deviations_and_the_noise_that_it_leaves() -> None:
    window = SOLVER.pose(RECORD, prior=Prior.box(SOLVER.unknowns), noise_known=False)
    window, found = SOLVER.fit(window, window.objective, random_generator(1), Deadline(), None)
    estimate, answer = explained_alone(window, found, NOTHING, 'off', Deadline())
    assert abs(estimate.parameters['k'] - 1.2) < 4.0 * estimate.stddev['k']
    assert 0.04 < next(iter(estimate.noise.values())) < 0.06
    assert answer.fine and answer.error < 0.3


def test_without_squares_the_best_point_is_told_alone() -> None:
    window = SOLVER.pose(RECORD, prior=Prior.box(SOLVER.unknowns), noise_known=False)
    window, found = SOLVER.fit(window, window.objective, random_generator(1), Deadline(), None)
    estimate, answer = best_alone(window, found, Deadline())
    assert np.isnan(estimate.stddev['k']) and answer.z is found.z
