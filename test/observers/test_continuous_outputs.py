"""Tests of obs_ros.observers.continuous_outputs."""

import math
from dataclasses import replace

import numpy as np
import pytest
from plants import NAN, VESSEL
from spinner import SHAFT, TURN

from obs_ros.observers.continuous_outputs import ContinuousOutputs


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
