"""The audit of Zhang et al. 2020 on made-up runs; claims and acceptance fail what fails."""

import math
import re

import numpy as np
import pytest

from benchmarks.papers.claims import Claim, Verdict
from benchmarks.papers.zhang import claims as told
from benchmarks.papers.zhang import report as flow_tables
from benchmarks.papers.zhang import theorem_claims as theorems
from benchmarks.papers.zhang import window_report as valve_tables
from benchmarks.papers.zhang.paper import PAPER as FRAME
from benchmarks.papers.zhang.plants import (
    CALM,
    CASES,
    CLOGGED,
    COLD,
    FAULTS,
    MOVING,
    PROCESS,
    UTILITY,
    flow_ratio,
    steady,
    truth_of,
)
from benchmarks.papers.zhang.printed import printed_observer
from benchmarks.papers.zhang.run import (
    CONTESTANTS,
    OURS,
    PAPER,
    PULLS,
    RATED,
    THETAS,
    UNKNOWN,
    Figures,
    Found,
    Measured,
    names_valve,
    noisy_cells,
    settling,
)
from benchmarks.papers.zhang.scores import alike
from benchmarks.papers.zhang.valves import OPENINGS, Valves
from benchmarks.papers.zhang.valves import watched as valves_watched
from benchmarks.papers.zhang.window_report import PRODUCT
from benchmarks.papers.zhang.windows import (
    NOISES,
    SIZES,
    WATCHES,
    Followed,
    Isolated,
    Watched,
    Windows,
    isolated,
    watched,
)
from obs_ros import load_observer
from plant_sim.scenarios.heat_exchanger import NOMINAL


def test_settling_is_the_last_time_out_of_the_band() -> None:
    t = np.arange(0.0, 10.0, 0.5)
    error = np.where(t < 3.0, 0.1, 0.0)
    error[t == 6.0] = -0.021
    assert settling(t, error, 1.0, 10.0) == 5.0
    assert settling(t, error, 1.0, 6.0) == 1.5
    assert settling(t, error, 7.0, 10.0) == 0.0
    assert settling(t, error, 1.0, 6.5) == math.inf  # out of it at the end
    error[-3:] = np.nan
    assert settling(t, error, 1.0, 10.0) == math.inf


@pytest.mark.parametrize(('case', 'column'), [(UTILITY, 1), (PROCESS, 0)])
def test_the_valve_is_named_whose_residual_changed_most(case, column: int) -> None:
    t = np.arange(0.0, case.end, 0.01)
    residuals = np.zeros((t.size, 2))
    residuals[:, 1 - column] = 0.3  # larger, but no change
    residuals[t >= case.fault + 0.5, column] = 0.16
    ones = np.ones_like(residuals)
    run = Found(t, ones, ones, residuals, ones)
    assert names_valve(run, case)
    assert not names_valve(run._replace(residuals=residuals[:, ::-1]), case)


def test_short_cases_are_the_truth_of_the_scenarios() -> None:
    """At rest before the fault; the specification's steady states, and the flows of the print."""
    np.testing.assert_allclose(steady(NOMINAL), (24.303, 20.108), atol=1e-3)
    np.testing.assert_allclose(steady(CLOGGED), (25.258, 21.141), atol=1e-3)
    t, _, y, flows = truth_of(UTILITY)
    assert np.abs(y[t < UTILITY.fault] - y[0]).max() < 1e-6
    np.testing.assert_allclose(flows[0], (4.17e-6, 4.22e-5), rtol=1e-3)
    assert flows[-1, 1] == pytest.approx(flows[0, 1] * math.sqrt(4.0 / 6.0))
    assert flow_ratio() == (pytest.approx(2.635, abs=1e-3), pytest.approx(10.12, abs=0.01))


def test_the_printed_gain_loses_the_flows() -> None:
    found = printed_observer(np.tile([80.0, 20.0], (500, 1)), 1e-3)
    assert (found[0] == 0.0).all()
    assert not (np.abs(found[-1] / (4.17e-6, 4.22e-5) - 1.0) < 0.02).any()


def figures_of(rms: float, settled: float) -> Figures:
    """Runs that are all alike, but for case 3, where feeding the model divides the error by 10."""
    good = Measured(np.full(2, settled), np.full(2, rms), True, 5.0, True, 0.1)
    quiet = {(one.label, case.label): [good] for one in CONTESTANTS for case in CASES}
    noisy = {(one.label, case.label): [good, good] for one in CONTESTANTS for case in FAULTS}
    for one in CONTESTANTS:
        share = 0.1 if one.observer == 'interconnected' else 1.0
        noisy[one.label, MOVING.label] = [good._replace(rms=share * good.rms)]
    slow = {(one.label, CALM.label): [good] for one in RATED}
    tuned = {theta: np.full(2, 100.0 / theta) for theta in THETAS}
    pulled = {factor: np.full(2, 0.2) for factor in PULLS}
    never = np.full(2, math.inf)
    t = np.arange(0.0, 12.0, 0.5)
    opened = np.where(t < 1.0, -0.5, 0.0)[:, None] * np.ones(2)
    valves = Valves(t, opened, np.full(2, 3e-4), np.array([0.0, 0.164]))
    return Figures(2, quiet, noisy, slow, [good], tuned, pulled, never, valves, windows_of(), 1)


@pytest.mark.parametrize(
    ('rms', 'settled', 'missed'), [(0.7, 0.5, 0), (0.9, 0.5, 1), (0.7, 0.6, 1), (3.0, 1.0, 2)]
)
def test_acceptance_of_the_flows_fails_what_is_missed(
    rms: float, settled: float, missed: int
) -> None:
    met = [one.met for one in flow_tables.acceptance(figures_of(rms, settled))]
    assert met.count(False) == missed
    assert met.count(True) == 5 - missed


def test_a_wrong_name_or_a_nan_fails_its_acceptance() -> None:
    figures = figures_of(0.7, 0.5)
    runs = figures.noisy[OURS.label, UTILITY.label]
    runs[0] = runs[0]._replace(named=False, finite=False)
    assert [one.met for one in flow_tables.acceptance(figures)].count(False) == 2


def verdicts(rows: list[Claim]) -> list[Verdict]:
    return [row.verdict for row in rows]


def test_robustness_is_judged_seed_by_seed() -> None:
    figures = figures_of(0.7, 0.5)
    rows = told.robustness(figures)
    # No seed of two shows nothing; the medians are the same.
    assert verdicts(rows) == [Verdict.NOT_SHOWN] * 2 + [Verdict.DOES_NOT_HOLD]
    for case in FAULTS:
        for one in (PAPER, UNKNOWN, OURS):
            figures.noisy[one.label, case.label] *= 10
        runs = figures.noisy[UNKNOWN.label, case.label]
        runs[:] = [run._replace(rms=2.0 * run.rms) for run in runs]
    rows = told.robustness(figures)
    assert verdicts(rows) == [Verdict.HOLDS, Verdict.HOLDS, Verdict.DOES_NOT_HOLD]
    assert rows[0].figure.startswith('20 of 20 (0.832 to 1.000)')
    runs = figures.noisy[UNKNOWN.label, UTILITY.label]
    runs[:8] = figures.noisy[PAPER.label, UTILITY.label][:8]
    # 12 of 20 may be chance, 4 of 20 are not.
    assert verdicts(told.robustness(figures))[:2] == [Verdict.HOLDS, Verdict.NOT_SHOWN]
    runs[:16] = figures.noisy[PAPER.label, UTILITY.label][:16]
    assert verdicts(told.robustness(figures))[:2] == [Verdict.HOLDS, Verdict.DOES_NOT_HOLD]


def test_a_valve_is_told_where_few_runs_name_another() -> None:
    figures = figures_of(0.7, 0.5)
    assert told.supervision(figures).verdict is Verdict.NOT_SHOWN  # too few to tell
    for case in FAULTS:
        figures.noisy[PAPER.label, case.label] *= 50
    assert told.supervision(figures).verdict is Verdict.HOLDS
    runs = figures.noisy[PAPER.label, UTILITY.label]
    runs[:9] = [run._replace(named=False) for run in runs[:9]]
    assert told.supervision(figures).verdict is Verdict.NOT_SHOWN  # 191 of 200 may be 91 %
    runs[:40] = [run._replace(named=False) for run in runs[:40]]
    assert told.supervision(figures).verdict is Verdict.DOES_NOT_HOLD


def test_a_claim_of_speed_needs_both_flows() -> None:
    rows = told.case_1(figures_of(0.7, 0.6))
    assert verdicts(rows) == [Verdict.HOLDS, Verdict.DOES_NOT_HOLD, Verdict.CANNOT_BE_JUDGED,
                              Verdict.DOES_NOT_HOLD]  # fmt: skip
    larger = told.tuning(figures_of(0.7, 0.6))
    assert verdicts(larger)[:2] == [Verdict.HOLDS, Verdict.DOES_NOT_HOLD]


def test_changes_of_temperature_have_a_sign_and_a_size() -> None:
    """The paper's own equations: Tp and Tu rise at 80 s, and fall too far at 150 s."""
    rows = told.changes()
    assert verdicts(rows) == [Verdict.DOES_NOT_HOLD] * 2 + [Verdict.CANNOT_BE_JUDGED]
    assert rows[0].figure == '+0.96 / +1.03 K' and rows[1].figure == '-1.23 / -0.74 K'
    assert alike(np.array([-0.8, -0.55]), (-0.9, -0.5))
    assert not alike(np.array([-0.8, 0.5]), (-0.9, -0.5))


def test_what_the_print_leaves_open_is_not_judged() -> None:
    assert told.chamber().verdict is Verdict.CANNOT_BE_JUDGED
    assert told.gain(figures_of(0.7, 0.5)).verdict == Verdict.DOES_NOT_HOLD
    assert told.one_coefficient().verdict == Verdict.DOES_NOT_HOLD


def test_the_theorems_want_what_case_1_does_not_have() -> None:
    """Tp passes the temperature of its inlet, and eta1 grows with theta from the observer's start.

    By hand: T' = -2 theta e there, and cond(S1) is the square of the golden section squared.
    """
    rows = theorems.theorems()
    assert verdicts(rows) == [Verdict.DOES_NOT_HOLD] * 2 + [Verdict.HOLDS, Verdict.DOES_NOT_HOLD]
    cond = ((1.0 + math.sqrt(5.0)) / 2.0) ** 4
    expected = 4.0 * cond * np.array([50.0 / 46.0, 10.0 / 15.0])
    np.testing.assert_allclose(theorems.least_eta1(), expected, rtol=1e-9)
    np.testing.assert_allclose(theorems.slowest_poles(), -4.08, atol=0.01)
    assert 0.0 < theorems.condition(10.0) < theorems.condition(1e3) < theorems.condition(1e5) < 1.0


def test_states_of_a_valve_are_those_of_its_model() -> None:
    figures = figures_of(0.7, 0.5)
    row = told.valve_states(figures)
    assert row.verdict is Verdict.HOLDS and row.figure == '0.50 / 0.50 s; 0.03 / 0.03'
    figures.valves.moving[1] = 0.03
    assert told.valve_states(figures).verdict is Verdict.DOES_NOT_HOLD
    row = told.faulty_valve(figures)
    assert row.verdict is Verdict.DOES_NOT_HOLD and row.figure == '0.00 / 16.40'
    figures.valves.faulty[1] = -0.01
    assert told.faulty_valve(figures).verdict is Verdict.HOLDS


def test_a_harder_spring_closes_a_valve_that_its_model_holds_open() -> None:
    """X = Aa pc / k at rest: with k2 + 1000 N/m the opening is 6089/7089 of the model's."""
    t, error, truth = valves_watched(PAPER, PROCESS)
    i = OPENINGS[1]
    assert t[-1] == pytest.approx(PROCESS.end)
    assert error[-1, i] / truth[-1, i] == pytest.approx(1000.0 / 6089.0, rel=1e-3)
    before = t < PROCESS.fault
    assert np.abs(error[before][:, i] / truth[before][:, i]).max() < 1e-6


def test_every_claim_and_every_table_is_filled() -> None:
    figures = figures_of(0.7, 0.5)
    rows = told.claims(figures)
    assert len(rows) == 28 and all(row.place and row.figure for row in rows)
    assert not any('|' in str(cell) for row in rows for cell in row)
    text = flow_tables.report(figures)
    assert sum(line.startswith('| ---') for line in text.splitlines()) == 9
    assert '{' not in text
    assert not [quote for quote in FRAME.quotes if not re.search(quote.measured, text, re.M)]


def test_contestants_share_their_noise_and_cases_do_not() -> None:
    cells = noisy_cells(40)
    seeds = {key: [seed for *_, seed in runs] for key, runs in cells.items()}
    rated = seeds[PAPER.label, UTILITY.label]
    assert rated == seeds[UNKNOWN.label, UTILITY.label] and len(set(rated)) == 40
    assert not set(rated) & set(seeds[PAPER.label, PROCESS.label])
    assert len(seeds[CONTESTANTS[2].label, UTILITY.label]) == 2
    assert COLD.label not in {case for _, case in cells}


GOOD = Isolated(True, True, True, 0.1, 0.5, 0)


CLEAN = Watched(
    p_error=np.full((100, 4), 0.01),
    p_sd=np.full((100, 4), 0.01),
    x_error=np.full((100, 4), 0.01),
    x_sd=np.full((100, 4), 0.01),
    weak=(('only dP1/k1^2 is determined (known from earlier windows)',),) * 100,
    alarms=0,
)


def windows_of(error: float = 0.004, fault: Isolated = GOOD, clean: Watched = CLEAN) -> Windows:
    """Windows that are all alike, but for the one fault and clean run given."""
    t = np.arange(74.0, 180.0, 0.5)
    run = Followed(t, np.full((t.size, 2), error), np.tile([5e3, 25.0], (t.size, 1)))
    quiet = run._replace(error=0.0 * run.error)
    faults = {noise: {name: [GOOD] * 5 for name in ('dP1', 'k1')} for noise in NOISES}
    faults['0.1 K, white']['k1'] = [fault] + [GOOD] * 4
    watches = {label: [CLEAN] for label in WATCHES}
    watches['pressures move, all four unknown'] = [clean]
    return Windows(quiet, [run], faults, watches)


@pytest.mark.parametrize(
    ('windows', 'missed'),
    [
        (windows_of(), 0),
        (windows_of(error=0.007), 1),
        (windows_of(fault=GOOD._replace(named=False)), 1),
        (windows_of(fault=GOOD._replace(partner=False)), 1),
        (windows_of(clean=CLEAN._replace(p_error=np.full((100, 4), 0.021))), 1),
        (windows_of(clean=CLEAN._replace(x_error=np.full((100, 4), 0.04))), 1),
    ],
)
def test_acceptance_of_windows_fails_what_is_missed(windows: Windows, missed: int) -> None:
    met = [one.met for one in valve_tables.window_acceptance(windows)]
    assert met.count(False) == missed
    tables = valve_tables.window_tables(windows)
    assert all('| --- |' in str(tables[name]) for name in ('followed', 'faults', 'watches'))


def test_words_that_are_missing_or_wrong_are_counted() -> None:
    half = CLEAN._replace(weak=CLEAN.weak[:50] + (('only dP1/k1 is determined',),) * 50)
    assert valve_tables.named([half]) == 0.5
    silent = CLEAN._replace(p_sd=np.full((100, 4), np.nan), p_error=np.full((100, 4), 0.5))
    assert valve_tables.wrong([silent]) == 0.0
    assert valve_tables.withheld([silent]) == 1.0


def test_every_contestant_is_an_observer_with_settings_that_it_takes() -> None:
    for one in CONTESTANTS:
        load_observer(one.observer)('heat_exchanger', **one.settings)


@pytest.mark.slow
@pytest.mark.parametrize('parameters', [('dP1', 'k1'), ('dP1', 'dP2', 'k1', 'k2')])
def test_at_constant_pressures_only_products_are_claimed(parameters: tuple[str, ...]) -> None:
    found = watched(moving=False, seed=3, parameters=parameters)
    assert all(any(text.startswith(PRODUCT) for text in weak) for weak in found.weak)
    assert np.isnan(found.p_sd).all()
    # The flows, and with them the temperatures, are known all the same.
    assert np.isfinite(found.x_sd[:, :2]).all()
    assert (np.abs(found.x_error[:, :2]) < 3.5 * found.x_sd[:, :2]).all()
    assert found.alarms == 0


@pytest.mark.slow
@pytest.mark.parametrize('parameter', SIZES)
def test_a_fault_names_its_valve_within_two_seconds(parameter: str) -> None:
    found = isolated(parameter, sigma=0.05, correlation=0.1, seed=3)
    assert found.named
    assert found.partner
    assert abs(found.error) < 0.5
    assert found.false == 0
