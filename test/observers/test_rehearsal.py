"""Tests of obs_ros.observers.rehearsal."""

from dataclasses import replace

import numpy as np
import pytest
from plants import OSCILLATOR
from sampled_stiff_plants import MOTOR

from obs_ros import Variable
from obs_ros.observers.rehearsal import rehearsed

START = np.array([1.0, -0.5]), np.array([0.8, 0.7])


def test_samples_follow_each_other_within_the_shortest_of_all_times() -> None:
    for model, gap, seconds in (
        (OSCILLATOR, 10.0, 0.05),  # its step
        (OSCILLATOR, 0.02, 0.02),  # the gap that starts an observer anew
        (replace(OSCILLATOR, max_step=np.inf), 10.0, 1.0 / np.sqrt(3.2)),  # about its frequency
        (replace(MOTOR, parameters=OSCILLATOR.parameters), 10.0, 1e-4),  # its fastest mode
    ):
        stamps = [sample.stamp for sample in rehearsed(model, *START, 3, gap)]
        assert np.diff(stamps) / 1e9 == pytest.approx([seconds] * 2, rel=0.5)


def test_the_last_outputs_are_at_the_ends_of_their_ranges() -> None:
    outputs = (Variable('y1', range=(-0.2, 0.2)), Variable('y2'))
    samples = list(rehearsed(replace(OSCILLATOR, outputs=outputs), *START, 3, 1.0))
    first, last = samples[0], samples[-1]
    assert first.y is not None and last.y is not None
    assert first.y[0] == pytest.approx(1.1)  # 1 + 0.1 u
    assert abs(last.y[0]) == 0.2
    assert last.y[1] == first.y[1]
