"""Tests of obs_ros.inference.innovation_gate."""

import math

import numpy as np
import pytest

from obs_ros.inference.innovation_gate import PASSED, REJECTED, REOPENED, Gate, judged


def sizes(count: int, scale: float = 1.0) -> list[float]:
    return (scale * np.abs(np.random.default_rng(1).standard_normal(count))).tolist()


def test_of_noise_nothing_is_rejected_and_far_ones_are() -> None:
    gate = Gate.of(1, 5.0, 10)
    assert [judged(gate, 0, size) for size in sizes(5000)] == [PASSED] * 5000
    assert gate.typical[0] == pytest.approx(1.0, abs=0.35)
    assert judged(gate, 0, 9.0) == REJECTED and gate.rejected[0] == 9.0
    assert judged(gate, 0, 1.0) == PASSED and gate.rejected[0] == gate.run[0] == 0


def test_a_run_of_rejections_opens_the_gate() -> None:
    gate = Gate.of(1, 5.0, 3)
    verdicts = [judged(gate, 0, 50.0) for _ in range(8)]
    assert verdicts == [REJECTED] * 3 + [REOPENED] + [REJECTED] * 3 + [REOPENED]


def test_noise_that_was_given_too_small_does_not_shut_it() -> None:
    gate = Gate.of(1, 5.0, 10)
    rejected = [judged(gate, 0, size) == REJECTED for size in sizes(2000, 8.0)]
    assert np.mean(rejected[300:]) < 0.002


def test_the_first_ones_pass_and_none_is_rejected_without_limit_or_number() -> None:
    gate = Gate.of(2, 5.0, 10, first=3)
    assert [judged(gate, 0, size) for size in (90.0, 40.0, 70.0)] == [PASSED] * 3
    assert judged(gate, 0, 300.0) == PASSED  # such sizes are typical by now
    assert judged(gate, 1, math.nan) == PASSED
    gate.clear()
    assert gate.typical[0] == 1.0
    assert judged(Gate.of(1, 0.0, 10), 0, 1e9) == PASSED
