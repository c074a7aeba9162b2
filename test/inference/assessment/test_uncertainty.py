"""Tests of obs_ros.inference.assessment.uncertainty."""

import numpy as np
from jump_windows import SIGMA, record, still, with_a_drift_jump

from obs_ros.core.residual_tests import inflation
from obs_ros.inference.assessment.uncertainty import Uncertainty
from obs_ros.inference.jumps.hypothesis import Hypothesis, hypothesis_at
from obs_ros.inference.jumps.piecewise import PiecewiseProblem
from obs_ros.inference.process_noise import ProcessNoise

WINDOW = record(0.1)


def uncertainty(best: Hypothesis, **known: object) -> Uncertainty:
    return Uncertainty(best, best.covariance, np.eye(2), **known)  # type: ignore[arg-type]


def test_jumps_at_two_times_look_like_a_ramp() -> None:
    one = with_a_drift_jump(WINDOW)
    assert not uncertainty(one).drifting
    place = int(one.layout.times[0])
    events = one.problem.events * 2
    problem = PiecewiseProblem(one.problem.objective, one.problem.prior, events)
    later = one.point[place:] + np.array([0.1, 0.0])
    two = hypothesis_at(problem, np.concatenate([one.point, later]))
    assert uncertainty(two).drifting


def test_noise_is_that_of_the_outputs_scale_less_its_correlation() -> None:
    best = still(WINDOW)
    np.testing.assert_allclose(uncertainty(best).noise, [SIGMA])
    coloured = uncertainty(best, correlation=0.5).noise
    np.testing.assert_allclose(coloured, SIGMA / np.sqrt(inflation(0.5)))
    walks = ProcessNoise(np.array([0.2, 0.0, 0.0]), np.array([0.07]))
    pushed = uncertainty(best, process_noise=walks, said='else')
    np.testing.assert_allclose(pushed.noise, [0.07])
    assert pushed.walking == () and pushed.disturbance.endswith('else')


def test_the_fit_is_that_of_the_hypothesis() -> None:
    """What jumps leave is noise; the model without them leaves what is not white."""
    assert uncertainty(with_a_drift_jump(WINDOW)).fit.is_noise
    assert not uncertainty(still(WINDOW)).fit.is_noise
