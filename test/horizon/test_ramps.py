"""Tests of obs_ros.horizon.ramps."""

import numpy as np
import pytest
from plants import LAG, lag_outputs, square_wave

from obs_ros import Record
from obs_ros.core.deadline import Deadline
from obs_ros.core.rng import random_generator
from obs_ros.horizon import stages
from obs_ros.horizon.ramps import drift_ahead, walked
from obs_ros.horizon.solver import Solver
from obs_ros.inference.assessment.uncertainty import Uncertainty
from obs_ros.inference.jumps.hypothesis import Hypothesis
from obs_ros.inference.window_state import WindowState
from obs_ros.optimization.result import Found

T = 0.1 * np.arange(600)
SIGMA = 0.02
SOLVER = Solver.of(LAG)
K = SOLVER.unknowns.names.index('k')


def explained(gain: np.ndarray) -> tuple[WindowState, Found, Hypothesis]:
    """A window with this gain (K - 1,), explained by jumps."""
    u = square_wave(T, 4.0)
    p = np.column_stack([gain, np.full(gain.size, 3.0)])
    y = lag_outputs(T, u, 0.5, p)
    y += SIGMA * np.random.default_rng(3).standard_normal(y.shape)
    posed = SOLVER.pose(Record(T, u, y), np.array([SIGMA]), noise_known=True)
    posed, found, still = stages.fit(posed, SOLVER, None, None, random_generator(1), Deadline())
    _, explanation = stages.explain(posed, found, None, Deadline(), still)
    return posed, found, explanation.hypothesis


def test_a_ramp_is_a_walk_whose_value_at_the_end_is_told() -> None:
    window, found, best = explained(np.linspace(1.5, 1.0, T.size - 1))
    assert best.jumps
    ramp = walked(window, found, best, Deadline())
    assert ramp is not None and ramp.is_noise
    assert ramp.noise.drifting(LAG) == ('k',)
    walk = ramp.noise.walks[1]
    assert 0.05 < walk * np.sqrt(T[-1]) < 1.0  # it goes by 0.5
    assert ramp.end.parameters is not None
    deviation = np.sqrt(ramp.end.covariance[1, 1])
    assert 0.0 < deviation < 0.1
    assert abs(ramp.end.parameters[0] - 1.0) < 3.0 * deviation
    at = ramp.hypothesis
    plain = Uncertainty(at, at.covariance, np.eye(2))
    assert not drift_ahead(plain).any()
    ahead = drift_ahead(ramp.added_to(plain))
    width = SOLVER.unknowns.scale.unit[K]
    expected = np.diag([(walk / width) ** 2 * T[-1], 0.0])
    np.testing.assert_allclose(ahead, expected, rtol=1e-9)


@pytest.mark.parametrize('size', [0.3, -0.5])
def test_a_jump_stays_one(size: float) -> None:
    window, found, best = explained(np.where(T[1:] > 31.0, 1.5 + size, 1.5))
    assert best.problem.events == ((K,),)
    assert walked(window, found, best, Deadline()) is None


def test_without_time_jumps_stay() -> None:
    window, found, best = explained(np.linspace(1.5, 1.0, T.size - 1))
    assert walked(window, found, best, Deadline(0.0)) is None
