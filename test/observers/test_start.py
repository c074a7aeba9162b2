"""Tests of obs_ros.observers.start."""

from dataclasses import replace

import numpy as np
import pytest
from plants import LAG

from obs_ros.core.prior_knowledge import with_knowledge
from obs_ros.inference.parameterisation import Unknowns
from obs_ros.observers.start import initial_values


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
