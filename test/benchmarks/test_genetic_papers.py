"""Tests of benchmarks.genetic_papers and benchmarks.genetic_runs."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.genetic_papers.plan import (
    GAINS_1995,
    MINIMUM,
    OSCILLATOR,
    SCENARIOS_1995,
    plan_1995,
    plan_2000,
    ways_1995,
    ways_2000,
)
from benchmarks.genetic_papers.report import (
    LUENBERGER_2000,
    gremling_asked,
    gremling_table,
    porter_asked,
    porter_table,
)
from benchmarks.genetic_papers.run import Outcome, diverged, run
from benchmarks.play import Contestant
from benchmarks.report import requirements

GOOD = Outcome(
    rms=np.array([0.01, 0.02, 0.02]),
    squares=np.array([1.0, 4400.0, 2100.0]),
    settled=2.0,
    resets=0,
    largest=3.0,
    seconds=1e-3,
)


def test_the_adaptive_luenberger_observer_is_the_papers() -> None:
    found = run(MINIMUM, ways_2000(MINIMUM)[4], 0)
    np.testing.assert_allclose(found.squares[1:], LUENBERGER_2000[MINIMUM], rtol=0.005)


def test_fixed_parameters_in_the_middle_are_the_specifications() -> None:
    found = run(MINIMUM, Contestant('fixed', 'open loop'), 0)
    np.testing.assert_allclose(found.squares[1:], (269.0, 283.0), rtol=0.01)


def test_a_constant_gain_settles_as_specified() -> None:
    way = Contestant('constant gain', 'constant gain', {'gains': GAINS_1995})
    base = run(OSCILLATOR, way, 0)
    assert base.settled == pytest.approx(2.73, abs=0.03)
    assert run(f'{OSCILLATOR}_disturbed', way, 0).rms[1] == pytest.approx(0.102, abs=0.002)


def test_only_what_is_random_runs_more_than_once() -> None:
    runs = plan_1995(7)
    assert len(runs[OSCILLATOR, 'GAO']) == 7
    assert len(runs[OSCILLATOR, 'constant gain']) == 1
    assert len(runs[f'{OSCILLATOR}_gaussian', 'constant gain']) == 7
    runs = plan_2000(7, 3)
    assert len(runs[MINIMUM, 'GASE, paper']) == 7
    assert sum(len(own) for (_, label), own in runs.items() if label == 'GASE, window_end') == 12


def test_a_start_again_or_a_large_error_is_a_divergence() -> None:
    assert not diverged(GOOD)
    assert diverged(replace(GOOD, resets=1))
    assert diverged(replace(GOOD, largest=np.nan))
    assert diverged(replace(GOOD, largest=2e3))


def test_the_report_marks_what_is_missed() -> None:
    outcomes = {(s, w.label): [GOOD] * 3 for s in SCENARIOS_1995 for w in ways_1995(s)}
    assert all(one.met for one in porter_asked(outcomes))
    outcomes[OSCILLATOR, 'GAO'] = [GOOD, GOOD, replace(GOOD, rms=np.array([0.0, 0.5]))]
    assert '| base | GAO | 3 | 0 | 0.18 | 0.02 | 0.5 | 2 | 3 |' in porter_table(outcomes)
    asked = 'base: GAO never diverges, mean RMS <= 0.08'
    assert f'| {asked} | 0 of 3, 0.18 | **no** |' in requirements(porter_asked(outcomes))
    outcomes[OSCILLATOR, 'GAO'] = [GOOD, GOOD, replace(GOOD, resets=1)]
    assert '| base | GAO | 3 | 1 | 0.02 | 0.02 | 0.02 | 2 | 3 |' in porter_table(outcomes)
    assert f'| {asked} | 1 of 3, 0.02 | **no** |' in requirements(porter_asked(outcomes))

    plants = (MINIMUM, 'observer_form_third_order_nmp')
    outcomes = {(s, w.label): [GOOD] for s in plants for w in ways_2000(s)}
    told = gremling_table(outcomes)
    assert '| minimum phase | GASE, paper | 1 | 4400 / 2100 |  | 4329 / 2008 |' in told
    assert '| non-minimum phase | GASE, paper | 1 | 4400 / 2100 |  | 7244 / 2563 |' in told
    met = {one.asked: one.met for one in gremling_asked(outcomes)}
    within = "GASE, paper within 30 % of the paper's means"
    assert met[f'minimum phase: {within}']
    assert not met[f'non-minimum phase: {within}']
