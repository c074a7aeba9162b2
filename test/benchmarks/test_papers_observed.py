"""Tests of what the genetic papers share: runs of observers, and how they are judged."""

from dataclasses import replace

import numpy as np
import pytest
from observed_runs import GOOD

from benchmarks.papers.observed import diverged, judged, observe, runs_of
from benchmarks.papers.truth import Truth, truth_of
from benchmarks.play import Contestant

OSCILLATOR = 'glycolytic_oscillator'
CONSTANT = Contestant('constant gain', 'constant gain', {'gains': (0.20, -0.35)})
GENETIC = Contestant('GAO', 'gao', seeded=True)


def test_a_constant_gain_settles_as_specified() -> None:
    ((run,),) = runs_of('porter', OSCILLATOR, CONSTANT, 7)
    assert observe(run).settled == pytest.approx(2.73, abs=0.03)
    ((run,),) = runs_of('porter', f'{OSCILLATOR}_disturbed', CONSTANT, 7)
    assert observe(run).rms[1] == pytest.approx(0.102, abs=0.002)


def test_only_what_is_random_runs_more_than_once() -> None:
    assert len(runs_of('porter', OSCILLATOR, GENETIC, 7)) == 7
    assert len(runs_of('porter', OSCILLATOR, CONSTANT, 7)) == 1
    assert len(runs_of('porter', f'{OSCILLATOR}_gaussian', CONSTANT, 7)) == 7


def test_observers_share_the_inputs_of_a_scenario_and_no_stream() -> None:
    other = GENETIC._replace(label='GAO, frozen')
    gaussian, mismatch = (f'{OSCILLATOR}_{case}' for case in ('gaussian', 'mismatch'))
    cells = [runs_of('porter', s, w, 50) for s in (gaussian, mismatch) for w in (GENETIC, other)]
    inputs = [[run.input_seed for (run,) in cell] for cell in cells]
    own = [run.own_seed for cell in cells for (run,) in cell]
    assert inputs[0] == inputs[1] and inputs[2] == inputs[3]
    assert len({*inputs[0], *inputs[2], *own}) == 100 + 200


def test_a_random_input_is_that_of_its_seed() -> None:
    one, again, other = (truth_of(f'{OSCILLATOR}_gaussian', seed).u for seed in (5, 5, 6))
    np.testing.assert_array_equal(one, again)
    assert np.std(one - other) == pytest.approx(0.5 * np.sqrt(2.0), rel=0.1)


def test_a_run_is_judged_by_the_truth() -> None:
    t = 0.01 * np.arange(5)
    truth = Truth(t, np.array([[0.0, 0.2, 0.4, 0.6, 0.8]] * 2).T, t[:, None], t[:, None])
    x = truth.x + np.array([[0.0, off] for off in (1.0, 1.0, -0.02, -0.02, 0.02)])
    told = [{'frozen': 0.0}, {'frozen': 0.0, 'L1': 2.0}, *[{'frozen': 1.0}] * 3]
    found = judged(True, truth, x, 0, told)
    np.testing.assert_allclose(found.rms, (0.0, 0.02), atol=1e-12)
    np.testing.assert_allclose(found.size, np.sqrt((0.16 + 0.36 + 0.64) / 3.0))
    np.testing.assert_allclose(found.squares, (0.0, 2.0 + 3 * 0.02**2), atol=1e-12)
    np.testing.assert_allclose(found.largest, (0.0, 1.0), atol=1e-12)
    assert (found.settled, found.frozen, found.last) == (0.02, 0.02, {'frozen': 1.0})
    assert found.onset == pytest.approx(0.0 - 0.03)
    assert found.trace is not None
    np.testing.assert_array_equal(found.trace.figures['L1'], (np.nan, 2.0, *[np.nan] * 3))
    assert judged(False, truth, truth.x + 1.0, 0, []).settled == np.inf


def test_a_start_again_or_a_large_error_is_a_divergence() -> None:
    assert not diverged(GOOD)
    assert diverged(replace(GOOD, resets=1))
    for state in range(3):
        for error in (np.nan, 2e3):
            largest = GOOD.largest.copy()
            largest[state] = error
            assert diverged(replace(GOOD, largest=largest))
