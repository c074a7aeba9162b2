"""Tests of benchmarks.papers.gremling: baselines, counts, and how claims are judged."""

import re
from dataclasses import replace

import numpy as np
import pytest
from observed_runs import GOOD

from benchmarks.papers.claims import Verdict
from benchmarks.papers.gremling.claims import LUENBERGER_SUMS, claims
from benchmarks.papers.gremling.counts import draws, operations
from benchmarks.papers.gremling.kalman import FAR, Configuration, configurations, filtered, unstable
from benchmarks.papers.gremling.paper import PAPER as FRAME
from benchmarks.papers.gremling.plan import (
    BASE_2,
    DEFAULT,
    EKF,
    JETS,
    LINEAR,
    LUENBERGER,
    MIDDLE,
    MINIMUM,
    PAPER,
    ways,
)
from benchmarks.papers.gremling.report import asked, linear_table
from benchmarks.papers.gremling.run import MEANS, OTHERS, Figures, count
from benchmarks.papers.gremling.scores import mean_interval, mean_text, unbounded, undetected
from benchmarks.papers.observed import Outcome, observe, runs_of
from benchmarks.papers.truth import truth_of
from benchmarks.report import requirements
from obs_ros import Sample, load_model, load_observer

CASE = 'jet_engine_case1'
# Runs of a spread that the paper's own have: means have an interval.
SPREAD = [
    replace(GOOD, squares=np.array([1.0, 4329.0 + off, 2008.0 + 0.3 * off]))
    for off in np.linspace(-2500.0, 2500.0, 50)
]


def figures(unstable_filters: bool = False, **own: list[Outcome]) -> Figures:
    """Return figures of good runs, but of those by label that are given."""
    outcomes = {
        (scenario, way.label): own.get(way.label, SPREAD if way.seeded else [GOOD])
        for scenario in (*LINEAR, *JETS)
        for way in ways(scenario)
    }
    tried = [one for case in JETS for one in configurations(case)]
    return Figures(outcomes, dict.fromkeys(tried, unstable_filters), operations(), draws(10, 1))


def verdicts(found: Figures) -> dict[str, Verdict]:
    return {f'{claim.place}: {claim.sentence}'[:30]: claim.verdict for claim in claims(found)}


def found(scenario: str, label: str) -> Outcome:
    (way,) = (way for way in ways(scenario) if way.label == label)
    return observe(*runs_of('gremling', scenario, way, 1)[0])


def test_the_adaptive_luenberger_observer_is_the_papers() -> None:
    own = found(MINIMUM, LUENBERGER)
    np.testing.assert_allclose(own.squares[1:], LUENBERGER_SUMS[MINIMUM][1], rtol=0.005)


def test_fixed_parameters_in_the_middle_are_the_specifications() -> None:
    np.testing.assert_allclose(found(MINIMUM, MIDDLE).squares[1:], (269.0, 283.0), rtol=0.01)


def test_rates_have_all_seeds_and_means_fewer() -> None:
    assert count(CASE, PAPER, 200) == 200
    assert count(MINIMUM, PAPER, 200) == MEANS
    assert count(MINIMUM, DEFAULT, 200) == count(CASE, BASE_2, 200) == OTHERS
    assert count(MINIMUM, PAPER, 3) == 3


def test_operations_are_those_of_equation_6_and_of_the_models_steps() -> None:
    criterion, whole = operations()
    assert criterion == {'additions': 2 * 200 * 51, 'multiplications': 200 * 52}
    # Eq. 18 by hand: of the three rates 6 products with parameters and 5 sums; of the step 3 and 3.
    per_step = {'additions': 8, 'multiplications': 9}
    for kind, each in per_step.items():
        assert whole[kind] - criterion[kind] == 200 * 51 * each


def test_draws_are_those_of_equations_7_to_9() -> None:
    for one in draws(20, seed=3):
        assert (one['parents'], one['sites']) == (190, 3 * 190)
        assert one['tests of mutation'] == 30 * 190
        assert 0 < one['traits out of range'] < 6 * 190
        assert one['alleles'] == pytest.approx(0.2 * 30 * 190, abs=5 * np.sqrt(5700 * 0.16))
    assert draws(2, seed=3) == draws(2, seed=3)


def test_the_papers_filter_follows_the_plant_where_its_model_is_right() -> None:
    truth = truth_of(CASE, 0)
    x = filtered(Configuration(CASE, 1e-7, 1e-7, 1e-1, kept=True), truth.u, truth.y)
    assert np.abs(x - truth.x)[1000:].max() < 0.1


def test_a_filter_that_leaves_the_plant_is_unstable() -> None:
    assert not unstable(Configuration(CASE, 1e-7, 1e-7, 1e-1, kept=True))
    assert unstable(Configuration(CASE, np.nan, 1e-7, 1e-1, kept=True))


def test_means_have_intervals() -> None:
    values = np.array([[1.0, 10.0], [2.0, 30.0], [3.0, 20.0]])
    mean, low, high = mean_interval(values)
    np.testing.assert_allclose(mean, (2.0, 20.0))
    np.testing.assert_allclose(high - mean, np.array([1.0, 10.0]) * 4.302653 / np.sqrt(3.0))
    np.testing.assert_allclose(mean - low, high - mean)
    wider = mean_interval(values, others=3)
    np.testing.assert_allclose(wider[2] - mean, (high - mean) * np.sqrt(2.0))
    assert mean_text(values[:1]) == '1 / 10'


def test_the_genetic_estimator_is_lost_where_a_filter_would_be() -> None:
    assert not unbounded(replace(GOOD, largest=np.array([0.1, FAR, 0.1])))
    assert unbounded(replace(GOOD, largest=np.array([0.1, 0.1, 1.1 * FAR])))
    assert unbounded(replace(GOOD, largest=np.array([0.1, np.nan, 0.1])))
    assert unbounded(replace(GOOD, resets=1))


def test_growth_is_detected_near_its_time() -> None:
    assert not undetected(replace(GOOD, onset=0.4))
    assert undetected(replace(GOOD, onset=-0.6))
    assert undetected(replace(GOOD, onset=np.inf))
    assert undetected(replace(GOOD, resets=1))


def test_verdicts_follow_the_figures() -> None:
    own = verdicts(figures())
    assert own['Table 1: Es x2 / x3, mean of 5'] is Verdict.HOLDS
    assert own['Table 2: Es x2 / x3, mean of 5'] is Verdict.DOES_NOT_HOLD
    assert own['Table 3: Es R / Phi, mean of 5'] is Verdict.CANNOT_BE_JUDGED
    assert own['6.3: an extended Kalman filter'] is Verdict.CANNOT_BE_JUDGED
    for claim in ('6.3: the genetic estimator nev', '6.2, 7: the growth of stall ce'):
        assert verdicts(figures(**{PAPER: [GOOD] * 200}))[claim] is Verdict.HOLDS
        bad = replace(GOOD, resets=1)
        lost = [GOOD] * 170 + [bad] * 30
        assert verdicts(figures(**{PAPER: lost}))[claim] is Verdict.DOES_NOT_HOLD
        few = [GOOD] * 48 + [bad] * 2
        assert verdicts(figures(**{PAPER: few}))[claim] is Verdict.NOT_SHOWN
    assert own['Eq. 6: a generation takes 2040'] is Verdict.DOES_NOT_HOLD
    assert own['Eq. 9: random floating-point n'] is Verdict.DOES_NOT_HOLD
    assert own['Eqs. 7, 8: random integers of '] is Verdict.HOLDS


def test_a_comparison_needs_an_interval_on_one_side() -> None:
    as_well = '4.2: the GA performs as well a'
    better = replace(GOOD, squares=np.array([1.0, 2000.0, 2100.0]))
    assert verdicts(figures(**{LUENBERGER: [better]}))[as_well] is Verdict.DOES_NOT_HOLD
    assert verdicts(figures(**{LUENBERGER: [GOOD]}))[as_well] is Verdict.HOLDS
    higher = 'Abstract, 7: for nonlinear sys'
    assert verdicts(figures())[higher] is Verdict.NOT_SHOWN
    best = replace(GOOD, squares=np.array([1.0, 9.0, 9.0]))
    assert verdicts(figures(**{EKF: [best]}))[higher] is Verdict.DOES_NOT_HOLD
    worse = replace(GOOD, squares=np.array([1.0, 9000.0, 9000.0]))
    assert verdicts(figures(**{EKF: [worse]}))[higher] is Verdict.HOLDS


def test_sums_with_another_base_are_alike_within_a_factor() -> None:
    base_2 = '2: a base-2 GA could just as e'
    assert verdicts(figures())[base_2] is Verdict.HOLDS
    twice = [replace(one, squares=2.0 * one.squares) for one in SPREAD]
    assert verdicts(figures(**{BASE_2: twice}))[base_2] is Verdict.DOES_NOT_HOLD
    half_more = [replace(one, squares=1.5 * one.squares) for one in SPREAD]
    assert verdicts(figures(**{BASE_2: half_more}))[base_2] is Verdict.NOT_SHOWN


def test_base_2_breeds_within_the_ranges_and_keeps_the_best() -> None:
    (way,) = (way for way in ways(CASE) if way.label == BASE_2)
    model = load_model('jet_engine')
    one = load_observer(way.observer)(model, seed=3, **way.settings)
    one.prepare()
    truth = truth_of(CASE, 0)
    for k in range(200):
        one.absorb(Sample(round(truth.t[k] * 1e9), y=truth.y[k], u=truth.u[k]))
    genes, values = one._genes, one._values
    assert set(np.unique(genes)) == {0, 1} and len(np.unique(values[:, 0])) > 20
    lower, upper = (np.array([getattr(p, end) for p in model.parameters])
                    for end in ('lower', 'upper'))  # fmt: skip
    estimated = one._coding
    assert (values >= estimated.lower).all() and (values <= estimated.upper).all()
    assert np.isin(estimated.lower, lower).all() and np.isin(estimated.upper, upper).all()
    order = np.argsort(np.random.default_rng(1).random(len(genes)))
    one._breed(order)
    elite = way.settings['elite']
    np.testing.assert_array_equal(one._genes[:elite], genes[order[:elite]])
    changed = np.mean(one._genes[elite:] != genes[order[elite:]])
    assert 0.05 < changed < 0.6


def test_the_report_marks_what_is_missed() -> None:
    outcomes = figures(**{PAPER: [GOOD]}).outcomes
    told = linear_table(outcomes)
    row = '| minimum phase | GASE, paper | 1 | 4400 / 2100 |  | 4329 / 2008 | 0.1 / 3 / 3 |'
    assert row in told
    met = {one.asked: one.met for one in asked(outcomes)}
    within = "GASE, paper within 30 % of the paper's means"
    assert met[f'minimum phase: {within}'] and not met[f'non-minimum phase: {within}']
    assert '**no**' in requirements(asked(outcomes))


def test_the_report_is_whole() -> None:
    text = FRAME.report(figures(unstable_filters=True))
    assert '{' not in text and '| 1e-07 | 24 of 24 | 24 of 24 |' in text
    assert not [quote for quote in FRAME.quotes if not re.search(quote.measured, text, re.M)]
