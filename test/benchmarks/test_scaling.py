"""The growth of the cost."""

import pytest

from benchmarks.scaling.curve import Curve
from benchmarks.scaling.metered import spent
from benchmarks.tanks import random_window
from obs_ros.models.three_tank import THREE_TANK


def test_a_metered_solve_counts_the_candidates_that_the_estimate_reports():
    run = spent(THREE_TANK, random_window(3, 60, 20.0).record, 3)
    assert run.estimate.outcome == 'converged'
    # A short window is rolled out as a whole, by every candidate: 59 steps each.
    assert run.steps == 59 * run.estimate.evaluations
    assert 0.0 < run.rest < 1.0


def test_growth_is_fitted_over_all_and_over_the_upper_half():
    x = [1.0, 10.0, 100.0, 1000.0]
    assert Curve('', '', x, [1.0, 1.0, 1.0, 100.0], (), (), '').exponents == pytest.approx((0.6, 2))
