"""Tests of obs_ros.horizon.stepped_windows."""

from functools import cache

import numpy as np
from stiff_plants import MOTOR, measured, truth, van_der_pol

from obs_ros import Record
from obs_ros.core.deadline import Deadline
from obs_ros.core.rng import random_generator
from obs_ros.horizon.moving_horizon import MovingHorizon
from obs_ros.horizon.settings import EstimationSettings
from obs_ros.horizon.solver import Solver
from obs_ros.horizon.stepped_windows import SteppedWindows

T = 0.01 * np.arange(400)
U = np.sign(np.sin(5.0 * T))[:, None]


@cache  # not at import, which every worker pays for
def motor() -> tuple[Record, dict[str, float]]:
    return measured(MOTOR, T, U, (0.0, 0.0), (1.3, 0.07))


def solver() -> Solver:
    return Solver.of(MOTOR, EstimationSettings(noise=motor()[1], process_noise='off'))


def test_before_any_window_the_model_goes_on_as_it_is() -> None:
    plain = solver()
    assert SteppedWindows(plain).kernels is plain.kernels


def test_a_stiff_plant_is_followed_from_window_to_window() -> None:
    windows, record = MovingHorizon(solver()), motor()[0]
    for k in range(3):
        part = slice(100 * k, 100 * k + 200)
        estimate = windows.solve(
            Record(T[part], U[part], record.y[part]), random_generator(0, k), Deadline()
        )
        assert estimate.usable
        assert estimate.figures['integration_error_sd'] < 0.3
        assert estimate.figures['integration_steps.rosenbrock'] < 4.0
        assert abs(estimate.parameters['R'] - 1.3) < 4.0 * estimate.stddev['R']


def test_a_parameter_that_jumps_is_found_where_it_moves_the_plant_s_own_jumps() -> None:
    relaxing, t = van_der_pol(100.0), np.linspace(0.0, 400.0, 201)
    nothing = np.empty((201, 0))
    before = truth(relaxing, t[:111], nothing[:111], (2.0, 0.0), (88.0,), states=True)
    after = truth(relaxing, t[110:], nothing[110:], before[-1], (128.0,), states=True)
    x = np.vstack([before, after[1:]])[:, :1]
    sd = 0.01 * float(x.std())
    y = x + sd * np.random.default_rng(1).standard_normal(x.shape)
    windows = MovingHorizon(Solver.of(relaxing, EstimationSettings(noise={'x': sd})))
    for k in (0, 25, 50, 75, 100):
        part = slice(k, k + 100)
        record = Record(t[part], nothing[part], y[part])
        estimate = windows.solve(record, random_generator(0, k), Deadline())
    (jump,) = estimate.jumps
    assert abs(jump.time - 220.0) < 3.0 * jump.time_stddev
    assert abs(estimate.parameters['mu'] - 128.0) < 5.0
