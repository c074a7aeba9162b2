"""Tests of obs_ros.observers.output_intake."""

import math
from dataclasses import replace

import numpy as np
from plants import VESSEL

from obs_ros.core.typing import Array
from obs_ros.inference.innovation_gate import Gate
from obs_ros.observers.innovation_gate import Admission
from obs_ros.observers.output_intake import OutputIntake


def intake(*, filled: bool = False, **fields: object) -> OutputIntake:
    """The intake of one output with noise of 0.1, whose variable has these fields."""
    outputs = tuple(replace(each, **fields) for each in VESSEL.outputs)
    model = replace(VESSEL, name='measured', outputs=outputs)
    return OutputIntake(
        model, Admission(Gate.of(1, 5.0, 9), outputs, np.array([0.1])), filled=filled
    )


def expected() -> Array:
    """The output that the model expects."""
    return np.array([2.0])


def test_the_first_output_passes_and_later_ones_go_through_the_gate() -> None:
    taken = intake()
    assert taken.taken(np.array([9.0]), expected, first=True) == 9.0
    taken.note(0.0, np.array([9.0]), np.array([7.0]), first=True)
    assert np.isnan(taken.taken(np.array([9.0]), expected, first=False))
    taken.note(1.0, np.array([math.nan]), np.array([math.nan]), first=False)
    assert taken.last_outlier.endswith('at 1.00 s (70 sigma)')
    assert sum(taken.counts.values()) == 1
    assert intake(filled=True).taken(np.array([9.0]), expected, first=False) == 2.0


def test_a_sensor_that_wraps_is_compared_by_the_shortest_way() -> None:
    taken = intake(period=4.0)
    taken.begin(np.array([18.0]))
    assert taken.taken(np.array([-1.9]), expected, first=False) == 18.1


def test_a_saturated_sensor_is_silent_where_the_model_is_beyond() -> None:
    taken = intake(range=(0.0, 1.5))
    assert np.isnan(taken.taken(np.array([1.5]), expected, first=False))
    assert taken.silent
    assert taken.taken(np.array([1.2]), lambda: np.array([1.1]), first=False) == 1.2
    assert not taken.silent


def test_what_the_model_expects_is_asked_for_once_and_only_where_it_is_needed() -> None:
    asked = []

    def counted() -> Array:
        asked.append(1)
        return expected()

    both = intake(range=(0.0, 1.5))
    both.taken(np.array([1.5]), counted, first=False)
    assert len(asked) == 1
    both.taken(np.array([1.0]), counted, first=True)
    assert len(asked) == 1
