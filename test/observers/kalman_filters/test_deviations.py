"""Tests of obs_ros.observers.kalman_filters.deviations."""

import math
from dataclasses import replace

import numpy as np
import pytest
from plants import LAG

from obs_ros import Variable
from obs_ros.core.prior_knowledge import with_knowledge
from obs_ros.inference.parameterisation import Unknowns
from obs_ros.models.three_tank import THREE_TANK
from obs_ros.observers.kalman_filters.deviations import (
    Deviations,
    KalmanSettings,
    begun,
    output_noise,
)

SHARES = KalmanSettings(
    initial_state=0.1, initial_parameter=0.2, state_walk=0.01, parameter_walk=0.03
)
LOG = replace(LAG, parameters=(replace(LAG.parameters[0], scale='log'), LAG.parameters[1]))


def deviations(unknowns: Unknowns) -> Deviations:
    return begun(unknowns, np.arange(3), SHARES)


def test_without_priors_and_walks_they_are_shares_of_the_boxes() -> None:
    found = deviations(Unknowns.of(LAG))
    np.testing.assert_allclose(found.width, [20.0, 4.8, 19.0])
    np.testing.assert_allclose(found.start, [2.0, 0.96, 3.8])
    np.testing.assert_allclose(found.walk, [0.2, 0.144, 0.57])
    assert found.relative.size == 0


def test_given_ones_go_before_shares() -> None:
    model = with_knowledge(LAG, {'x': 0.5, 'tau': math.inf}, {'x': (1.0, 0.3), 'k': (2.0, 0.4)})
    found = deviations(Unknowns.of(model))
    np.testing.assert_allclose(found.start, [0.3, 0.4, 3.8])
    np.testing.assert_allclose(found.walk, [0.5, 0.144, 0.57])  # infinite: no windows, no walk
    held = deviations(Unknowns.of(model, states=(), fixed={'x': 1.0}))
    np.testing.assert_allclose(held.start, [0.0, 0.4, 3.8])


@pytest.mark.parametrize(('walk', 'places'), [(None, []), (math.inf, []), (0.01, [1])])
def test_on_a_log_scale_a_given_walk_is_a_share_of_the_value(
    walk: float | None, places: list[int]
) -> None:
    model = LOG if walk is None else with_knowledge(LOG, {'k': walk})
    found = deviations(Unknowns.of(model))
    assert found.relative.tolist() == places
    assert found.walk[1] == pytest.approx(0.01 if places else 0.144)


def test_noise_that_is_not_given_is_a_share_of_what_the_box_makes_of_the_output() -> None:
    unknowns = Unknowns.of(THREE_TANK)
    noise = output_noise(unknowns, {'h2': 0.5}, 1e-3)
    assert noise[0] == pytest.approx(0.1, rel=0.05)  # h1 lies in [0, 100] cm
    assert noise[1] == 0.5
    bounded = replace(THREE_TANK, outputs=(Variable('h1', lower=0.0, upper=20.0), Variable('h2')))
    assert output_noise(Unknowns.of(bounded), {}, 1e-3)[0] == pytest.approx(0.02)
