"""The audit of Yang, Li & Dahhou 2020."""

import math

import numpy as np
import pytest

from benchmarks.papers.claims import Verdict
from benchmarks.papers.yang import algorithm_claims, problem_claims, table_claims, theorem
from benchmarks.papers.yang.claims import claims
from benchmarks.papers.yang.comparisons import as_good, combined_p, overall, rank, ratio
from benchmarks.papers.yang.convergence import follow
from benchmarks.papers.yang.reference import FITNESSES, SNRS, SYMBOLS, Cell, printed_errors
from benchmarks.papers.yang.report import report
from benchmarks.papers.yang.run import (
    DEFAULT,
    FIRST_SAMPLE,
    PAPER,
    WAYS,
    Figures,
    Solved,
    applies,
    bounds,
    solved,
)
from benchmarks.papers.yang.sequence import LATER, PERIODS, UNCHANGED, truth_of
from benchmarks.papers.yang.sequence import WAYS as SEQUENCES
from benchmarks.papers.yang.starts import CUBIC, UNIFORM, Start, started
from benchmarks.tanks import PAPER_WINDOWS, paper_window

TABLE_1 = [Cell('ft1', window, snr) for window in PAPER_WINDOWS for snr in SNRS[1:]]


def figures(errors: dict[tuple[Cell, str], np.ndarray], **parts) -> Figures:
    """Figures of made-up errors (seeds, 4)."""
    solves = {
        pair: [Solved(row, (63.0, 63.0), (1.9, 1.9)) for row in own] for pair, own in errors.items()
    }
    empty = dict(starts={}, sequences={}, collapses={}, followed={}, quick=True)
    cells = [*dict.fromkeys(cell for cell, _ in errors)]
    return Figures(len(next(iter(errors.values()))), cells, solves, **(empty | parts))


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


def test_a_run_is_printed_for_every_cell_with_noise():
    cells = [Cell(f, window, snr) for f in FITNESSES for window in PAPER_WINDOWS for snr in SNRS]
    errors = {cell: printed_errors(cell) for cell in cells}
    for cell, own in errors.items():
        assert np.isnan(own).all() == np.isinf(cell.snr_db)
    np.testing.assert_allclose(
        errors[Cell('ft1', 'T3', 40.0)], [3.83e-4, 0.0, 2.152e-3, 0.018], atol=1e-9
    )
    np.testing.assert_allclose(
        errors[Cell('ft2', 'T1', -20.0)], [0.093336, 0.151281, 0.280199, 39.962134], atol=1e-9
    )


# 95th percentiles of the errors of another implementation, 50 seeds.
P95 = {'ft1': (1.9e-3, 3.5e-4, 1.8e-3, 0.087), 'ft2': (7.2e-3, 7.0e-3, 1.1e-2, 0.85)}


@pytest.mark.parametrize('fitness', FITNESSES)
def test_paper_mode_is_as_good_as_another_implementation(fitness):
    errors = [solved(Cell(fitness, 'T1', 40.0), PAPER, seed).errors for seed in range(5)]
    assert (np.median(errors, axis=0) <= P95[fitness]).all()


def test_a_first_sample_taken_as_exact_spoils_h3():
    cell = Cell('ft1', 'T2', 0.0)
    h3 = {
        way: np.median([solved(cell, way, seed).errors[3] for seed in range(8)])
        for way in (PAPER, FIRST_SAMPLE)
    }
    assert h3[FIRST_SAMPLE] > 2.0 * h3[PAPER]


def test_the_distance_at_the_truth_is_that_of_the_noise():
    found = solved(Cell('ft1', 'T2', 0.0), PAPER, 1)
    # Of 1000 samples of unit noise each, over both outputs.
    assert found.distance[1] == pytest.approx(2.0 * math.sqrt(1000.0), rel=0.05)
    assert found.distance[0] == pytest.approx(found.distance[1], rel=0.05)
    assert 0.99 * found.correlation[1] < found.correlation[0] <= 2.0


def test_a_followed_search_reaches_the_optimum():
    window = paper_window('T3', 40.0, 1)
    run = follow(window, SYMBOLS, 'memetic', 'least_squares', 1)
    seen = run.excess[np.isfinite(run.excess)]
    assert seen.size < run.excess.size  # it began on a part of the window
    assert (seen[1:] <= seen[:-1]).all()
    assert seen[-1] < 0.41


def test_the_default_search_beats_paper_mode_where_noise_is_small():
    cell = Cell('ft1', 'T3', 40.0)
    paper, default = (
        np.median([solved(cell, way, seed).errors for seed in range(4)], axis=0)
        for way in (PAPER, DEFAULT)
    )
    assert (10.0 * default < paper).all()


def test_printed_runs_like_ours_pass_and_far_better_ones_do_not():
    rng = np.random.default_rng(1)

    def errors(factor: float) -> dict[tuple[Cell, str], np.ndarray]:
        spread = rng.lognormal(size=(len(TABLE_1), 200, 4))
        return {
            (cell, PAPER): factor * np.maximum(printed_errors(cell), 5e-7) * own
            for cell, own in zip(TABLE_1, spread)
        }

    like, far = errors(1.0), errors(30.0)
    assert combined_p(like, TABLE_1) > 0.05
    assert combined_p(far, TABLE_1) < 1e-6
    assert 60 <= rank(like, TABLE_1[0]) <= 140
    together, each = as_good(far, TABLE_1[0])
    assert together == 0 and each.max() < 10


def test_a_ratio_of_medians_has_its_interval():
    rng = np.random.default_rng(2)
    a, b, c = rng.lognormal(size=(3, 200))
    twice = ratio(2.0 * a, b)
    assert twice.low < 2.0 < twice.high and twice.worse and not twice.better
    assert ratio(c, b).word == 'no difference'
    assert overall([2.0 * a, 0.5 * a], [a, a]).middle == pytest.approx(1.0)


def test_errors_of_one_run_do_not_count_as_many():
    rng = np.random.default_rng(4)
    cells = [Cell(fitness, window, math.inf) for fitness in FITNESSES for window in PAPER_WINDOWS]
    errors = {(cell, PAPER): np.repeat(rng.lognormal(size=(50, 1)), 4, axis=1) for cell in cells}
    alone = ratio(*(errors[Cell(fitness, 'T1', math.inf), PAPER][:, 0] for fitness in FITNESSES))
    claim = table_claims.noise_free_parameters(figures(errors))
    assert claim.figure.startswith(f'T1: {alone}; ')


def test_a_correlation_is_no_deviation():
    assert algorithm_claims.deviation().verdict is Verdict.DOES_NOT_HOLD


def test_the_distance_of_eq_13_is_one():
    assert problem_claims.euclidean().verdict is Verdict.HOLDS


def test_the_slope_of_the_tanks_has_no_bound():
    """It is p delta An sqrt(2g) / A over the root of the head."""
    assert problem_claims.slope(1e-4) == pytest.approx(3.6e-3 * math.sqrt(1962.0) / 1e-2, rel=1e-6)
    assert problem_claims.lipschitz().verdict is Verdict.DOES_NOT_HOLD


def test_ratios_on_neither_side_show_nothing():
    rng = np.random.default_rng(6)
    own = {
        (Cell(fitness, window, snr), PAPER): rng.lognormal(size=(200, 4))
        for fitness in FITNESSES for window in PAPER_WINDOWS for snr in SNRS
    }  # fmt: skip
    alike = figures(own)
    assert table_claims.euclidean_better(alike).verdict is Verdict.NOT_SHOWN
    assert table_claims.noise_free_parameters(alike).verdict is Verdict.HOLDS
    better = {pair: (0.5 if pair[0].fitness == 'ft1' else 1.0) * own[pair] for pair in own}
    assert table_claims.euclidean_better(figures(better)).verdict is Verdict.HOLDS
    reverse = {pair: (2.0 if pair[0].fitness == 'ft1' else 1.0) * own[pair] for pair in own}
    assert table_claims.on_the_whole(figures(reverse)).verdict is Verdict.DOES_NOT_HOLD


def test_the_printed_true_levels_are_not_those_of_the_stated_constants():
    claim = table_claims.true_levels()
    assert claim.verdict is Verdict.DOES_NOT_HOLD
    assert claim.figure == 'T2: 17.7167 cm; T3: 52.9333 cm'


def test_one_population_that_cannot_follow_refutes_the_theorem():
    fine = theorem.Collapse(100, shrunk=True, found=True, walls=False, rises=0)
    lost = fine._replace(found=False)
    own = {(Cell('ft1', 'T1', 40.0), PAPER): np.ones((3, 4))}
    near_wall = lost._replace(walls=True)
    for runs, expected in (([fine] * 200, Verdict.HOLDS),
                           ([fine] * 3, Verdict.NOT_SHOWN),
                           ([fine] * 199 + [lost], Verdict.DOES_NOT_HOLD),
                           ([fine] * 199 + [near_wall], Verdict.HOLDS)):  # fmt: skip
        found = figures(own, collapses={'cubic': runs, 'uniform': runs})
        assert algorithm_claims.theorem(found).verdict is expected


def test_the_truth_of_the_theorems_plant_has_no_distance():
    objective, truth = theorem.problem()
    assert objective.costs(truth[None])[0] == 0.0
    assert objective.costs(truth[None] + 1e-3)[0] > 1.0


def test_the_period_after_the_paper_goes_on_where_t3_ends():
    assert PERIODS == ('T1', 'T2', 'T3', UNCHANGED) and PERIODS[1:] == LATER
    last, p = truth_of('T3')
    after, same = truth_of(UNCHANGED)
    assert (p == same).all()
    assert np.abs(after[0] - last[-1]).max() < 0.1  # cm, in a second
    assert np.abs(after[0] - [86.27335, 52.72873, 65.42825]).max() < 1e-3


def test_a_start_has_the_same_bits_again():
    first = started('paper', 'cubic', 'T3', 7)
    assert first == started('paper', 'cubic', 'T3', 7)
    assert 0.0 < first.error < 0.1


def test_the_papers_search_is_made_once_but_where_levels_cross():
    once = 25 * 86
    evaluations = {name: started('paper', 'cubic', name, 7).evaluations for name in PAPER_WINDOWS}
    assert 2 * once <= evaluations['T1'] < 2 * once + 25
    assert all(once <= evaluations[name] < once + 25 for name in ('T2', 'T3'))


def test_claims_and_tables_come_from_figures_alone():
    rng = np.random.default_rng(3)
    cells = [Cell(f, window, snr) for f in FITNESSES for window in PAPER_WINDOWS for snr in SNRS]
    errors = {
        (cell, way): rng.lognormal(size=(5, 4)) for cell in cells for way in WAYS
        if applies(cell, way)
    }  # fmt: skip
    searches = [(search, kind) for search in ('paper', 'default') for kind in (CUBIC, UNIFORM)]
    pairs = [(*search, window) for search in searches for window in PAPER_WINDOWS]
    found = figures(
        errors,
        starts={pair: [Start(1e-3, 2150)] * 5 for pair in pairs},
        sequences={way: rng.lognormal(size=(5, len(PERIODS))) for way in SEQUENCES},
        collapses={CUBIC: [theorem.Collapse(100, True, True, False, 0)] * 5},
    )
    judged = {(claim.place, claim.sentence): claim.verdict for claim in claims(found)}
    assert len(judged) == 21
    assert [*judged.values()].count(Verdict.CANNOT_BE_JUDGED) == 1
    text = report(found)
    assert '## Table 2 (f_t2, correlation)' in text and '| warm, Np 10 |' in text
