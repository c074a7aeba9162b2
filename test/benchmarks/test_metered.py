"""Solves that count their candidate-steps."""

import numpy as np

from benchmarks.metered import Meter, spent
from benchmarks.tanks import random_window
from obs_ros.integration.backends import kernels_for
from obs_ros.integration.grid import Grid
from obs_ros.integration.linear_path import LinearPath
from obs_ros.integration.path import LANES
from obs_ros.models.three_tank import THREE_TANK


def test_a_metered_solve_counts_the_candidates_that_the_estimate_reports() -> None:
    run = spent(THREE_TANK, random_window(3, 60, 20.0).record, 3)
    assert run.estimate.outcome == 'converged'
    # A short window is rolled out as a whole, by every candidate: 59 steps each. Before the search
    # a few are rolled out by steps and by twice as many, after it the optimum.
    assert run.steps == 59 * (run.estimate.evaluations + 3 * LANES + 1)
    assert 0.0 < run.rest < 1.0


def test_passes_of_the_filter_and_likelihoods_count_by_their_lanes() -> None:
    meter = Meter(kernels_for(THREE_TANK))
    grid = Grid.of(THREE_TANK, random_window(3, 60, 20.0).record, np.ones(2))
    x0, p, noise = np.full(3, 50.0), np.full(3, 0.5), np.full(2, 0.1)
    found = meter.filter(grid, x0, p, np.repeat([0.1, 0.0], 3), noise)
    assert meter.count.steps == 59 * 7
    walks = np.repeat([[0.1], [0.0]], 3, axis=0) * np.ones(5)
    with meter.linear_paths():
        LinearPath.of(found).neg2_log_likelihood(walks, noise[:, None] * np.ones(5))
    assert meter.count.steps == 59 * 7 + 60 * 5
    LinearPath.of(found).neg2_log_likelihood(walks, noise[:, None] * np.ones(5))
    meter.paths(grid.injected(found.injection, found.S), x0[:, None], p[:, None])
    assert meter.count.steps == 59 * 8 + 60 * 5
    assert meter.count.calls == 3
