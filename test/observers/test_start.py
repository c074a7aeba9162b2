"""Tests of obs_ros.observers.start."""

import math
from dataclasses import replace

import numpy as np
import pytest
from plants import LAG, NAN
from spinner import SHAFT

from obs_ros.core.prior_knowledge import with_knowledge
from obs_ros.inference.parameterisation import Unknowns
from obs_ros.observers.start import initial_values, kept_bounds


def test_given_values_go_before_priors_nominal_values_and_the_middle() -> None:
    k, tau = LAG.parameters
    model = replace(LAG, parameters=(replace(k, nominal=1.5), replace(tau, nominal=None)))
    model = with_knowledge(model, {}, {'x': (1.25, 0.3)})
    middle = 0.5 * (tau.lower + tau.upper)
    np.testing.assert_allclose(initial_values(Unknowns.of(model), {}), [1.25, 1.5, middle])
    given = initial_values(Unknowns.of(model), {'tau': 7.0, 'x': -2.0})
    np.testing.assert_allclose(given, [-2.0, 1.5, 7.0])
    with pytest.raises(ValueError, match='h9'):
        initial_values(Unknowns.of(model), {'h9': 1.0})


def test_values_start_as_given_or_at_the_middle_of_their_box() -> None:
    values = initial_values(Unknowns.of(SHAFT), {'rate': 7.0})
    np.testing.assert_allclose(values, [0.0, 7.0, 10.05, 2.505])
    with pytest.raises(ValueError, match='rate starts from nan, which is not a finite number'):
        initial_values(Unknowns.of(SHAFT), {'rate': NAN})


def test_bounds_that_are_kept_are_those_given_but_for_states_with_a_period() -> None:
    lower, upper = kept_bounds(SHAFT, {'k': (1.0, 2.0), 'angle': (-1.0, 1.0)})
    np.testing.assert_array_equal(lower, [-math.inf, -40.0, 1.0, 0.01])
    np.testing.assert_array_equal(upper, [math.inf, 40.0, 2.0, 5.0])
