"""Tests of obs_ros.observers.beginning."""

import math
from dataclasses import replace

import numpy as np
import pytest
from plants import NAN, VESSEL
from spinner import SHAFT, TURN

from obs_ros.inference.parameterisation import Unknowns
from obs_ros.observers.beginning import ContinuousOutputs, initial_values, kept_bounds


def test_values_start_as_given_or_at_the_middle_of_their_box() -> None:
    values = initial_values(Unknowns.of(SHAFT), {'rate': 7.0})
    np.testing.assert_allclose(values, [0.0, 7.0, 10.05, 2.505])
    with pytest.raises(ValueError, match='rate starts from nan, which is not a finite number'):
        initial_values(Unknowns.of(SHAFT), {'rate': NAN})


def test_bounds_that_are_kept_are_those_given_but_for_states_with_a_period() -> None:
    lower, upper = kept_bounds(SHAFT, {'k': (1.0, 2.0), 'angle': (-1.0, 1.0)})
    np.testing.assert_array_equal(lower, [-math.inf, -40.0, 1.0, 0.01])
    np.testing.assert_array_equal(upper, [math.inf, 40.0, 2.0, 5.0])


def test_outputs_follow_what_was_expected_last() -> None:
    """Steps of 1.2 rad over many turns, one value missing, one half a turn off."""
    outputs = ContinuousOutputs(SHAFT)
    outputs.begin(np.array([19.0, 0.0]))
    true = 20.0 + 1.2 * np.arange(60)
    for k, angle in enumerate(true):
        measured = (angle + np.pi) % TURN - np.pi
        y = np.array([NAN if k == 7 else measured + (2.9 if k == 15 else 0.0), measured])
        taken = outputs.taken(y)
        assert taken[1] == measured
        if k == 7:
            assert math.isnan(taken[0])
        elif k != 15:
            assert taken[0] == pytest.approx(angle)
        # Of the outlier the observer believes a tenth.
        wrong = 0.9 * (taken[0] - angle) if k == 15 else 0.0
        outputs.note(taken, np.array([wrong, 0.0]))


def test_without_a_period_outputs_are_taken_as_they_are() -> None:
    outputs = ContinuousOutputs(replace(VESSEL, name='straight'))
    outputs.begin(np.array([100.0]))
    y = np.array([-5.0])
    assert outputs.taken(y) is y
