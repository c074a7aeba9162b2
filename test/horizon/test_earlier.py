"""Tests of obs_ros.horizon.earlier."""

from dataclasses import replace

import numpy as np
from plants import LAG, lag_outputs, square_wave

from obs_ros import Record
from obs_ros.core.deadline import Deadline
from obs_ros.core.rng import random_generator
from obs_ros.horizon import stages
from obs_ros.horizon.earlier import Earlier, beside_known_jumps, earlier_jumps, explained
from obs_ros.horizon.found_jumps import Explained
from obs_ros.horizon.solver import Solver
from obs_ros.inference.jumps.hypothesis import Hypothesis
from obs_ros.inference.window_state import WindowState

T = 0.1 * np.arange(400)
SIGMA = 0.05
SOLVER = Solver.of(LAG)
K = SOLVER.unknowns.names.index('k')
NOTHING = Earlier(None, None, None)


def window(*spikes: int, jump: float = 0.6, first: int = 0) -> WindowState:
    u = square_wave(T)
    p = np.tile([1.2, 3.0], (T.size - 1, 1))
    p[200:, 0] += jump
    y = lag_outputs(T, u, 0.5, p)
    y += SIGMA * np.random.default_rng(3).standard_normal(y.shape)
    y[list(spikes)] += 12.0 * SIGMA
    record = Record(T[first:], u[first:], y[first:])
    return SOLVER.pose(record, np.array([SIGMA]), noise_known=True)


def jumped(posed: WindowState) -> tuple[WindowState, Hypothesis]:
    posed, found, still = stages.fit(posed, SOLVER, None, None, random_generator(1), Deadline())
    posed, _, explanation = explained(posed, found, None, NOTHING, Deadline(), still)
    return posed, explanation.hypothesis


def test_a_jump_is_found_beside_outliers() -> None:
    posed, best = jumped(window(90, 310))
    assert best.problem.events == ((K,),)
    assert sorted(round(o.time, 1) for o in posed.outliers) == [9.0, 31.0]
    _, calm = jumped(window())
    np.testing.assert_allclose(best.point, calm.point, atol=0.01)


def test_outliers_alone_make_no_jump() -> None:
    posed, best = jumped(window(90, 91, 399, jump=0.0))
    assert not best.jumps
    assert len(posed.outliers) == 3


def test_outliers_beside_a_known_jump_are_left_out_without_a_search() -> None:
    _, best = jumped(window())
    warm = SOLVER.unknowns.point({'x': 0.0, 'k': 1.2, 'tau': 3.0})
    earlier = replace(NOTHING, warm=warm, explained=Explained.by(best))
    later = window(330, first=50)
    clean, known = beside_known_jumps(later, earlier, Deadline())
    assert [round(outlier.time, 1) for outlier in clean.outliers] == [33.0]
    assert known is not None and known.problem.events == ((K,),)
    assert known.squares < 420.0
    calm = window(first=50)
    same, again = beside_known_jumps(calm, earlier, Deadline())
    assert same is calm and again is not None
    expected = earlier_jumps(calm, earlier, Deadline())
    assert expected is not None
    np.testing.assert_array_equal(again.point, expected.point)
    assert earlier_jumps(calm, NOTHING, Deadline()) is None
