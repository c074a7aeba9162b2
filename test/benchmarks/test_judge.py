"""The independent judge of a search."""

import math

import numpy as np

from benchmarks.judge import FINER, Judge
from benchmarks.papers.yang.reference import SYMBOLS
from benchmarks.tanks import paper_window, random_window
from benchmarks.windows.run import UNKNOWNS
from obs_ros.models.three_tank import THREE_TANK


def test_the_judge_recovers_a_truth_without_noise_from_elsewhere():
    window = paper_window('T2', math.inf, 0)
    judge = Judge(THREE_TANK, window.record, SYMBOLS, window.truth)
    assert judge.squares(window.truth) < 1e-6
    elsewhere = {**window.truth, 'p1': 0.4, 'p3': 0.6, 'h3': 30.0}
    assert judge.squares(elsewhere) > 1e3
    assert judge.optimum(elsewhere, 0, seed=1) < 1e-6


def test_in_finer_steps_the_judge_sees_less_of_levels_that_cross():
    """Of its own steps' error; a search that takes finer ones would be judged wrong by that."""
    for seed in (1000, 1005, 1007):
        window = random_window(seed, 50, math.inf)
        coarse, fine = (
            Judge(THREE_TANK, window.record, UNKNOWNS, {}, finer=steps).squares(window.truth)
            for steps in (1, FINER)
        )
        assert window.crossing
        assert fine < 0.02 * coarse


def test_the_judges_derivatives_are_those_of_its_residuals():
    window = paper_window('T3', 20.0, 0)
    judge = Judge(THREE_TANK, window.record, SYMBOLS, window.truth)
    z, direction = judge.point(window.truth), np.array([0.3, -0.2, 0.5, 0.1])
    change = (judge.residuals(z + 1e-5 * direction) - judge.residuals(z - 1e-5 * direction)) / 2e-5
    np.testing.assert_allclose(judge.jacobian(z) @ direction, change, rtol=1e-3, atol=1e-3)
