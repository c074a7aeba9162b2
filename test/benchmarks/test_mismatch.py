"""Windows that no model fits: tanks that overflow, scores of sequences, costs."""

from pathlib import Path

import numpy as np
import pytest

from benchmarks.mismatch.__main__ import main
from benchmarks.mismatch.cost import CASES, FITS, Cost, cost, runs
from benchmarks.mismatch.plants import NOISE, TANKS, TOP, overflowing
from benchmarks.mismatch.report import acceptance
from benchmarks.mismatch.run import DURATION, SCENES, SPACINGS, Followed, followed
from benchmarks.mismatch.scores import cycles, frozen, nearness
from obs_ros import Record, solve_window
from obs_ros.core.typing import Array


def test_tanks_overflow_where_they_have_a_top() -> None:
    free, p = overflowing(3, 600, np.inf)
    held, same = overflowing(3, 600)
    low, _ = overflowing(3, 600, 4.0)
    much, _ = overflowing(3, 600, flood='much')
    assert (much.y > TOP - 5.0 * NOISE).sum() > 2 * (held.y > TOP - 5.0 * NOISE).sum()
    np.testing.assert_array_equal(p, same)
    np.testing.assert_array_equal(free.u, low.u)
    assert low.y.max() < 4.0 + 5.0 * NOISE < free.y.max()
    assert held.y.max() <= TOP + 5.0 * NOISE


def test_the_model_explains_tanks_that_do_not_overflow() -> None:
    record, p = overflowing(4, DURATION, np.inf)
    found = solve_window(TANKS, record, noise={'y1': NOISE, 'y2': NOISE})
    assert found.outcome == 'converged'
    np.testing.assert_allclose([found.parameters[k] for k in ('k1', 'k3', 'k4')], p, rtol=0.05)


@pytest.mark.parametrize('spacing', SPACINGS)
def test_a_sequence_is_followed_window_by_window(spacing: str) -> None:
    found = followed(next(iter(SCENES)), spacing, 'off', 5, 3)
    assert found.values.shape == found.sd.shape == found.alone.shape == (3, 3)
    assert len(found.outcomes) == len(found.alone_outcomes) == 3
    # The first window of a sequence has nothing to lean on.
    np.testing.assert_allclose(found.values[0], found.alone[0], rtol=1e-2)


def sequence(values: Array, alone: Array) -> Followed:
    sd, outcomes = np.ones_like(values), ['converged'] * len(values)
    return Followed(values, sd, alone, 2.0 * sd, outcomes, outcomes)


def test_nearness_leaves_aside_what_is_not_determined() -> None:
    run = sequence(np.array([[0.0], [4.0], [9.0], [9.0]]), np.zeros((4, 1)))
    assert nearness([run]) == (1, 4)
    assert nearness([run], larger=True) == (2, 4)
    withheld = run._replace(sd=np.array([[1.0], [1.0], [1.0], [np.nan]]))
    assert nearness([withheld]) == (1, 3)


def test_a_value_that_stands_still_is_frozen_only_where_the_window_moves() -> None:
    moving = 5.0 * np.random.default_rng(1).standard_normal((40, 2)).cumsum(axis=0)
    assert frozen(sequence(np.zeros((40, 2)), moving)) > 30
    once = moving.copy()
    once[7] = once[6]
    assert frozen(sequence(once, moving)) == 0
    assert frozen(sequence(moving, moving)) == 0
    assert frozen(sequence(np.zeros((40, 2)), np.zeros((40, 2)))) == 0


def test_a_difference_that_comes_back_every_four_windows_is_a_cycle() -> None:
    rng = np.random.default_rng(2)
    noise = rng.standard_normal((40, 2))
    turns = np.tile(rng.standard_normal((4, 1)), (10, 1))
    run = sequence(np.column_stack([turns, noise[:, :1]]), np.zeros((40, 2)))
    assert cycles(run).tolist() == [True, False]
    assert not cycles(sequence(noise, noise)).any()


def test_what_is_asked_is_judged() -> None:
    values = np.random.default_rng(3).standard_normal((40, 3))
    good = {('3 parameters', 'a quarter', 'auto'): [sequence(values, values)] * 5}
    steps = {FITS: (10, 10, 12), 'overflow': (20, 40, 50), 'random outputs': (20, 40, 51)}
    costs = {
        ('tanks', kind, 'known'): [Cost(each, 0.1, 'converged') for each in own]
        for kind, own in steps.items()
    }
    assert [row.met for row in acceptance(good, costs)] == [True] * 4 + [True, False]
    bad = {('3 parameters', 'a quarter', 'auto'): [sequence(np.zeros((40, 3)), 7.0 * values)] * 5}
    assert [row.met for row in acceptance(bad, {})] == [False, False, False, True]


def test_costs_are_of_windows_that_differ_in_their_outputs_alone() -> None:
    pytest.importorskip('numba')
    for case in CASES.values():
        fitting = case.window(FITS, 1)
        for kind in case.kinds:
            other = case.window(kind, 1)
            np.testing.assert_array_equal(other.t, fitting.t)
            np.testing.assert_array_equal(other.u, fitting.u)
            assert np.abs(other.y - fitting.y).max() > 0.1
    fits, wrong = (cost('lag, 3 unknowns', kind, 'known', 1) for kind in (FITS, 'square wave'))
    assert fits.outcome == 'converged' != wrong.outcome
    assert 0 < fits.steps < wrong.steps
    assert isinstance(CASES['lag, 3 unknowns'].window(FITS, 1), Record)
    assert len(runs(0)) == 2 * sum(1 + len(case.kinds) for case in CASES.values())


@pytest.mark.slow
def test_the_command_reports_sequences_and_costs(tmp_path: Path) -> None:
    text = main(['--seeds', '1', '--windows', '6', '--results', str(tmp_path)])
    assert text.count('| a quarter |') == text.count('| a window |') == 6
    assert text.count('x the cost of one that fits') == 18
    assert (tmp_path / 'mismatch.md').read_text() == text
