"""Tests of obs_ros.inference.assessment.profile."""

import numpy as np
from plants import window_of

from obs_ros import Model, Record, Variable
from obs_ros.inference.assessment.profile import widened_by_profile
from obs_ros.inference.jumps.hypothesis import Hypothesis, hypothesis_at
from obs_ros.inference.jumps.piecewise import PiecewiseProblem
from obs_ros.inference.prior import Prior

# x' = a^2: around a = 0 far from linear.
SQUARE = Model(
    name='square',
    states=(Variable('x', lower=-10.0, upper=10.0),),
    outputs=(Variable('y'),),
    parameters=(Variable('a', lower=0.0, upper=1.0),),
    dynamics=lambda t, x, u, p: (p[0] * p[0],),
    output=lambda t, x, u, p: (x[0],),
)


def fitted(a: float, sigma: float) -> Hypothesis:
    """The best hypothesis of a window without noise, in which a is known to about sigma / a."""
    t = 0.1 * np.arange(101)
    record = Record(t, np.zeros((t.size, 0)), (a * a * t)[:, None])
    objective = window_of(SQUARE, record, sigma, states=['x'])
    problem = PiecewiseProblem(objective, Prior.box(objective.unknowns))
    return hypothesis_at(problem, np.array([0.5, a]))


def test_a_straight_valley_is_left_as_it_is() -> None:
    best = fitted(0.6, 0.05)
    covariance, bent = widened_by_profile(best)
    assert not bent
    np.testing.assert_array_equal(covariance, best.covariance)


def test_a_bent_one_is_as_wide_as_its_squares_say() -> None:
    """Two deviations s below a the squares grow (1 - s / a)^2 times as much as they should."""
    best = fitted(0.2, 1.2)
    covariance, bent = widened_by_profile(best)
    assert bent
    ratio = covariance[1, 1] / best.covariance[1, 1]
    assert 1.4**2 < ratio < 2.0**2  # a half, and the margin
