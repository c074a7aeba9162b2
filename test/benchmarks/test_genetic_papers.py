"""Tests of benchmarks.genetic_papers and benchmarks.genetic_runs."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.genetic_papers.report import (
    GAINS_1995,
    LUENBERGER_2000,
    MINIMUM,
    OSCILLATOR,
    SCENARIOS_1995,
    gremling_table,
    porter_table,
    tasks_1995,
    tasks_2000,
    ways_1995,
    ways_2000,
)
from benchmarks.genetic_papers.run import Outcome, Run, Way, diverged, run

GOOD = Outcome(
    rms=np.array([0.01, 0.02, 0.02]),
    squares=np.array([1.0, 4400.0, 2100.0]),
    settled=2.0,
    resets=0,
    largest=3.0,
    seconds=1e-3,
)


def test_the_adaptive_luenberger_observer_is_the_papers() -> None:
    found = run(Run(MINIMUM, ways_2000(MINIMUM)[4], 0))
    np.testing.assert_allclose(found.squares[1:], LUENBERGER_2000[MINIMUM], rtol=0.005)


def test_fixed_parameters_in_the_middle_are_the_specifications() -> None:
    found = run(Run(MINIMUM, Way('fixed', 'open loop'), 0))
    np.testing.assert_allclose(found.squares[1:], (269.0, 283.0), rtol=0.01)


def test_a_constant_gain_settles_as_specified() -> None:
    way = Way('constant gain', 'constant gain', {'gains': GAINS_1995})
    base = run(Run(OSCILLATOR, way, 0))
    assert base.settled == pytest.approx(2.73, abs=0.03)
    assert run(Run(f'{OSCILLATOR}_disturbed', way, 0)).rms[1] == pytest.approx(0.102, abs=0.002)


def test_only_what_is_random_runs_more_than_once() -> None:
    runs = tasks_1995(7)
    assert sum(t.way.label == 'GAO' and t.scenario == OSCILLATOR for t in runs) == 7
    assert sum(t.way.label == 'constant gain' and t.scenario == OSCILLATOR for t in runs) == 1
    runs = tasks_2000(7, 3)
    assert sum(t.way.label == 'GASE, paper' and t.scenario == MINIMUM for t in runs) == 7
    assert sum(t.way.label == 'GASE, window_end' for t in runs) == 12


def test_a_start_again_or_a_large_error_is_a_divergence() -> None:
    assert not diverged(GOOD)
    assert diverged(replace(GOOD, resets=1))
    assert diverged(replace(GOOD, largest=np.nan))
    assert diverged(replace(GOOD, largest=2e3))


def test_the_report_marks_what_is_missed() -> None:
    outcomes = {(s, w.label): [GOOD] * 3 for s in SCENARIOS_1995 for w in ways_1995(s)}
    assert '**no**' not in porter_table(outcomes)
    outcomes[OSCILLATOR, 'GAO'] = [GOOD, GOOD, replace(GOOD, rms=np.array([0.0, 0.5]))]
    assert '| base | GAO | 3 | 0 | 0.18 | 0.02 | 0.5 | 2 | 3 | **no** |' in porter_table(outcomes)
    outcomes[OSCILLATOR, 'GAO'] = [GOOD, GOOD, replace(GOOD, resets=1)]
    assert '| base | GAO | 3 | 1 | 0.02 | 0.02 | 0.02 | 2 | 3 | **no** |' in porter_table(outcomes)

    plants = (MINIMUM, 'observer_form_third_order_nmp')
    outcomes = {(s, w.label): [GOOD] for s in plants for w in ways_2000(s)}
    told = gremling_table(outcomes, 1)
    assert '| minimum phase | GASE, paper | 1 | 4400 / 2100 |  | 4329 / 2008 | yes |' in told
    assert '| non-minimum phase | GASE, paper | 1 | 4400 / 2100 |  | 7244 / 2563 | **no** |' in told
