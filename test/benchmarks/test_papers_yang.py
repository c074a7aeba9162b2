"""The audit of Yang, Li & Dahhou 2020."""

import math

import numpy as np
import pytest

from benchmarks.papers.yang.convergence import follow
from benchmarks.papers.yang.reference import FITNESSES, SNRS, SYMBOLS, Cell, references
from benchmarks.papers.yang.run import FIRST_SAMPLE, MEMETIC, PAPER, bounds, errors_of
from benchmarks.tanks import PAPER_WINDOWS, paper_window


@pytest.mark.parametrize(
    ('window', 'expected'),
    [
        ('T1', [0.01303, 0.00120, 0.01204, 0.2491]),
        ('T2', [0.01679, 0.000385, 0.06294, 0.2822]),
        ('T3', [0.00896, 0.000465, 0.02005, 0.6690]),
    ],
)
def test_the_cramer_rao_bound_is_the_specifications(window, expected):
    np.testing.assert_allclose(bounds(window, 4), expected, rtol=0.02)


def test_the_reference_covers_every_cell_of_both_tables():
    assert set(references()) == {
        Cell(fitness, window, snr)
        for fitness in FITNESSES
        for window in PAPER_WINDOWS
        for snr in SNRS
    }
    reference = references()[Cell('ft1', 'T3', 40.0)]
    assert reference.p95.tolist() == [0.074, 0.0025, 0.13, 4.3]
    assert reference.run.tolist() == [3.8e-4, 0.0, 2.2e-3, 0.018]
    assert np.isnan(references()[Cell('ft2', 'T1', math.inf)].run).all()


@pytest.mark.parametrize('fitness', FITNESSES)
def test_paper_mode_is_as_good_as_the_reference(fitness):
    cell = Cell(fitness, 'T1', 40.0)
    errors = [errors_of(cell, PAPER, seed) for seed in range(5)]
    assert (np.median(errors, axis=0) <= references()[cell].p95).all()


def test_a_first_sample_taken_as_exact_spoils_h3():
    cell = Cell('ft1', 'T2', 0.0)
    h3 = {
        way: np.median([errors_of(cell, way, seed)[3] for seed in range(8)])
        for way in (PAPER, FIRST_SAMPLE)
    }
    assert h3[FIRST_SAMPLE] > 2.0 * h3[PAPER]


def test_a_followed_search_reaches_the_optimum():
    window = paper_window('T3', 40.0, 1)
    run = follow(window, SYMBOLS, 'memetic', 'least_squares', 1)
    seen = run.excess[np.isfinite(run.excess)]
    assert seen.size < run.excess.size  # it began on a part of the window
    assert (seen[1:] <= seen[:-1]).all()
    assert seen[-1] < 0.41


def test_the_default_search_beats_paper_mode_where_noise_is_small():
    cell = Cell('ft1', 'T3', 40.0)
    paper, memetic = (
        np.median([errors_of(cell, way, seed) for seed in range(4)], axis=0)
        for way in (PAPER, MEMETIC)
    )
    assert (10.0 * memetic < paper).all()
