"""Tests of obs_ros.inference.jumps.moves."""

from dataclasses import replace

import numpy as np
import pytest
from jump_windows import DRIFT, GAIN, SIGMA, TIGHT, T, U, changed, record, still, with_a_drift_jump

from obs_ros import Record
from obs_ros.inference.jumps.moves import (
    EarlierJump,
    JoinedJump,
    NewJump,
    promising_moves,
    with_jump,
    with_one_exchanged,
    with_one_more,
    without_one,
)
from obs_ros.inference.prior import Prior


def test_a_new_jump_starts_near_the_true_time() -> None:
    base = still(record(0.6, 4.23))
    moves = promising_moves(base)
    best = moves[0]
    assert isinstance(best, NewJump)
    assert best.parameter == DRIFT
    assert abs(best.times[np.argmax(best.gains)] - 0.423) < 1 / 8
    assert [move.score for move in moves] == sorted((move.score for move in moves), reverse=True)
    first, *others = best.start(base)
    assert len(others) <= 1
    assert first.problem.events == ((DRIFT,),)
    assert first.point[3] == pytest.approx(0.423, abs=0.02)
    assert first.point[4] - first.point[2] == pytest.approx(0.3, abs=0.05)


def test_a_jump_that_joins_another_starts_at_its_time() -> None:
    y = record(0.6).y[:, 0] + 0.7 * changed(4.23, GAIN) * SIGMA / 2.0
    base = with_a_drift_jump(Record(T, U, y))
    (move,) = (m for m in promising_moves(base) if isinstance(m, JoinedJump))
    assert (move.parameter, move.event) == (GAIN, 0)
    (start,) = move.start(base)
    assert start.problem.events == ((DRIFT, GAIN),)
    np.testing.assert_array_equal(start.point[:5], base.point)
    assert start.point[5] == base.point[GAIN] + move.size


def test_a_jump_joins_also_one_at_the_very_start() -> None:
    base = with_a_drift_jump(record(0.6))
    at_start = replace(base, point=np.where(np.arange(5) == 3, 0.0, base.point))
    (start,) = JoinedJump(1.0, GAIN, event=0, size=0.1).start(at_start)
    assert (start.problem.events, start.earlier) == (((DRIFT, GAIN),), ())
    np.testing.assert_array_equal(start.point[5], base.point[GAIN] + 0.1)


def test_an_earlier_jump_widens_the_prior_and_starts_where_it_is() -> None:
    prior = Prior(np.array([0.5, 0.65, 0.8]), TIGHT.precision, gap=0.5)
    base = still(record(), prior)
    best = promising_moves(base)[0]
    assert isinstance(best, EarlierJump)
    (start,) = best.start(base)
    assert (start.problem.events, start.earlier) == ((), (DRIFT,))
    assert start.point is base.point
    assert start.problem.prior.precision[DRIFT, DRIFT] == pytest.approx(12.0, rel=0.02)
    # A parameter jumps once at most in the time in which nobody looked.
    assert EarlierJump not in map(type, promising_moves(replace(base, earlier=(GAIN, DRIFT))))


def test_before_an_earlier_second_jump_of_a_parameter_all_that_follows_moves_along() -> None:
    base = with_a_drift_jump(record(0.6))
    start = with_jump(base, DRIFT, 0.2, -0.1)
    assert start.problem.events == ((DRIFT,), (DRIFT,))
    before, later = base.point[[2, 4]]
    np.testing.assert_allclose(start.point[4:], [later - 0.1, 0.2, before - 0.1])
    # A later one leaves what came before it.
    start = with_jump(base, DRIFT, 0.8, -0.1)
    np.testing.assert_allclose(start.point[4:], [later, 0.8, later - 0.1])


def test_of_two_jumps_each_is_left_out_once() -> None:
    base = with_a_drift_jump(record(0.6))
    (joined,) = JoinedJump(1.0, GAIN, event=0, size=0.1).start(base)
    both = replace(base, problem=joined.problem, point=joined.point)
    starts = list(without_one(both))
    assert [start.problem.events for start in starts] == [((GAIN,),), ((DRIFT,),)]
    np.testing.assert_array_equal(starts[0].point, [*base.point[:4], joined.point[5]])
    np.testing.assert_array_equal(starts[1].point, base.point)
    (alone,) = without_one(base)
    assert alone.problem.events == ()
    np.testing.assert_array_equal(alone.point, base.point[:3])


def test_another_parameter_joins_where_that_may_count() -> None:
    """Its score must not be 100 times less likely than the base."""
    base = with_a_drift_jump(record(0.6))
    (joined,) = JoinedJump.screened(base, [GAIN, DRIFT])
    for reach, counts in ((-joined.score * 1.1, True), (-joined.score * 0.9, False)):
        settings = replace(base.problem.settings, least_weight=float(np.exp(-0.5 * reach)))
        assert settings.reach == pytest.approx(reach)
        starts = list(
            with_one_more(replace(base, problem=replace(base.problem, settings=settings)))
        )
        assert len(starts) == counts
        if counts:
            assert starts[0].problem.events == ((DRIFT, GAIN),)
            assert starts[0].parameters == {DRIFT, GAIN}


def test_a_parameter_that_jumped_is_exchanged_for_the_other() -> None:
    base = with_a_drift_jump(record(0.6))
    (start,) = with_one_exchanged(base)
    assert start.problem.events == ((GAIN,),)
    np.testing.assert_array_equal(start.point[:4], base.point[:4])
    # The size that changes the outputs most nearly as the drift's jump does.
    drift, gain = changed(10.0 * base.point[3], DRIFT), changed(10.0 * base.point[3], GAIN)
    size = (base.point[4] - base.point[2]) * (drift @ gain) / (gain @ gain)
    assert start.point[4] - start.point[GAIN] == pytest.approx(size, rel=1e-3)
