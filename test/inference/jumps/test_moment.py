"""Tests of obs_ros.inference.jumps.moment."""

import numpy as np
import pytest
from plants import square_wave, window_of

from obs_ros import Model, Record, Variable
from obs_ros.horizon.found_jumps import jumps_of
from obs_ros.inference.jumps.hypothesis import Hypothesis, hypothesis_at
from obs_ros.inference.jumps.moment import MOMENT, time_variance
from obs_ros.inference.jumps.piecewise import PiecewiseProblem
from obs_ros.inference.parameterisation import BOX_VARIANCE
from obs_ros.inference.prior import Prior

FEEDTHROUGH = Model(
    name='feedthrough',
    states=(Variable('x', lower=-10.0, upper=10.0),),
    inputs=(Variable('u'),),
    outputs=(Variable('y'),),
    parameters=(Variable('g', lower=0.0, upper=2.0),),
    dynamics=lambda t, x, u, p: (u[0] - x[0],),
    output=lambda t, x, u, p: (x[0] + p[0] * u[0],),
)
NODES, SIGMA, PLACE = 401, 0.05, 2
INTERVAL = 0.1
T = INTERVAL * np.arange(NODES)
BEFORE, AFTER, MOMENT_AT = 0.5, 0.8, 20.13  # s


def hypothesis(still: int = 0, seed: int = 1) -> Hypothesis:
    """The truth, g jumping in the middle; without an input for `still` samples around it."""
    u = square_wave(T, 1.7)
    u[np.abs(np.arange(NODES) - 201) < 0.5 * still] = 0.0
    x = np.zeros(NODES)
    for k in range(NODES - 1):
        x[k + 1] = u[k] + (x[k] - u[k]) * np.exp(-INTERVAL)
    y = x + np.where(MOMENT_AT < T, AFTER, BEFORE) * u
    noise = SIGMA * np.random.default_rng(seed).standard_normal(NODES)
    objective = window_of(FEEDTHROUGH, Record(T, u, y + noise), SIGMA)
    problem = PiecewiseProblem(objective, Prior.box(objective.unknowns), events=((1,),))
    return hypothesis_at(problem, np.array([0.5, BEFORE / 2.0, MOMENT_AT / T[-1], AFTER / 2.0]))


@pytest.mark.parametrize('seed', range(4))
def test_what_shows_in_the_outputs_only_is_dated_by_the_samples(seed: int) -> None:
    best = hypothesis(seed=seed)
    linear = best.covariance[PLACE, PLACE]
    assert linear == pytest.approx(BOX_VARIANCE)  # derivatives tell nothing
    assert np.sqrt(time_variance(best, PLACE, linear)) * T[-1] < INTERVAL
    (found,) = jumps_of(best, best.covariance)
    assert abs(found.time - MOMENT_AT) < 3.0 * found.deviation < 4.0 * INTERVAL


def test_it_lies_anywhere_where_no_input_shows_it() -> None:
    best = hypothesis(still=40)
    found = np.sqrt(time_variance(best, PLACE, BOX_VARIANCE)) * T[-1]
    assert found == pytest.approx(40.0 * INTERVAL / np.sqrt(12.0), rel=0.2)


def test_what_ends_beyond_reach_is_not_told() -> None:
    best = hypothesis(still=3 * MOMENT.reach)
    assert time_variance(best, PLACE, BOX_VARIANCE) == BOX_VARIANCE


def test_what_derivatives_tell_stays() -> None:
    assert time_variance(hypothesis(), PLACE, 1e-3) == 1e-3
