"""Tests of obs_ros.replay.history."""

import math
from dataclasses import replace

import numpy as np
from plants import VESSEL

from obs_ros import Sample
from obs_ros.core.estimate import Estimate, Jump, Outcome
from obs_ros.replay.forecast import Forecast
from obs_ros.replay.history import History

S = 10**9


def estimate(t, x=0.0, outcome=Outcome.CONVERGED, **more):
    state = {'x': x}
    return Estimate(
        parameters={'d': 2.0, 'g': 0.0}, initial_state=state, state=state, stddev={'x': 0.5},
        outcome=outcome, message=f'at {t}', t0=0.0, t1=t, stamp=round(t * S), solve_time=0.25,
        residual_rms=0.1, output_rms={'y': 0.1}, interval={'x': (x - 1.0, x + 2.0)}, **more,
    )  # fmt: skip


def test_numbers_stand_in_the_order_of_the_estimates():
    history = History(VESSEL)
    assert [history.add(estimate(t, 10.0 * t)) for t in (1.0, 2.0)] == [0, 1]
    history.add(estimate(3.0, math.nan, Outcome.DIVERGED))
    assert len(history) == 3 and history.stamps.tolist() == [S, 2 * S, 3 * S]
    np.testing.assert_array_equal(
        history.rows('values'), [[10.0, 2.0, 0.0], [20.0, 2.0, 0.0], [math.nan, 2.0, 0.0]]
    )
    np.testing.assert_array_equal(history.rows('deviations')[0], [0.5, math.nan, math.nan])
    np.testing.assert_array_equal(history.rows('lower')[1], [19.0, math.nan, math.nan])
    np.testing.assert_array_equal(history.rows('upper')[1], [22.0, math.nan, math.nan])
    assert history.rows('residuals').tolist() == [[0.1]] * 3 == history.rows('rms').tolist()
    assert history.outcomes == {'converged': 2, 'diverged': 1}
    assert history.messages == {'converged': 'at 2.0', 'diverged': 'at 3.0'}
    assert history.outcome_of == ['converged', 'converged', 'diverged']
    assert history.solve_time == 0.75


def test_a_forecast_is_noted_with_its_estimate():
    history = History(VESSEL)
    for t in (1.0, 2.0, 3.0):
        history.add(estimate(t))
    history.judged([Forecast(1, *np.array([[0.25], [0.5], [0.125], [0.75]]))])
    np.testing.assert_array_equal(history.rows('forecasts')[:, 0], [math.nan, 0.25, math.nan])
    np.testing.assert_array_equal(history.rows('held')[:, 0], [math.nan, 0.5, math.nan])
    near = np.hstack([history.rows('near'), history.rows('near_held')])
    np.testing.assert_array_equal(near, [[math.nan] * 2, [0.125, 0.75], [math.nan] * 2])


def test_walks_and_figures_are_noted_as_far_as_they_are_told():
    history = History(VESSEL)
    history.add(estimate(1.0))
    figures = {'forecast_skill': 0.9, 'scatter_over_sd.g': 1.5}
    history.add(estimate(2.0, walks={'x': 0.1}, figures=figures))
    nan = math.nan
    np.testing.assert_array_equal(history.rows('walks'), [[nan] * 3, [0.1, nan, nan]])
    np.testing.assert_array_equal(history.rows('skill')[:, 0], [nan, 0.9])
    np.testing.assert_array_equal(history.rows('scatter'), [[nan, nan], [nan, 1.5]])


def test_measured_and_applied_are_as_recorded():
    history = History(VESSEL)
    history.record(Sample(S, u=np.array([3.0])))
    history.record(Sample(2 * S, y=np.array([4.0]), u=np.array([5.0])))
    assert history.applied.rows.tolist() == [[3.0], [5.0]]
    assert history.applied.stamps.tolist() == [S, 2 * S]
    assert history.measured.rows.tolist() == [[4.0]]


def test_a_sample_is_on_the_path_by_the_first_window_that_holds_it():
    history = History(VESSEL)
    for t1, states in ((2.0, [1.0, 2.0, 3.0]), (3.0, [9.0, 9.0, 4.0])):
        times = np.array([t1 - 2.0, t1 - 1.0, t1])
        history.add(estimate(t1, times=times, states=np.array(states)[:, None]))
    assert history.path.stamps.tolist() == [0, S, 2 * S, 3 * S]
    assert history.path.rows[:, 0].tolist() == [1.0, 2.0, 3.0, 4.0]


def test_all_jumps_are_counted_and_so_many_kept():
    history = History(VESSEL, most_jumps=2)
    for k in range(3):
        jump = Jump(float(k), 0.1, {'d': 1.0}, {'d': 0.1}, new=True, stamp=k * S)
        history.add(estimate(float(k), jumps=(jump,)))
    assert history.jump_count == 3 and [jump.time for jump in history.jumps] == [0.0, 1.0]
    assert history.retraction_count == 0 and history.standing == history.jumps


def test_a_jump_that_is_taken_back_stands_no_more():
    history = History(VESSEL)
    first, second = (
        Jump(t, 0.1, {'d': 1.0}, {'d': 0.1}, new=True, stamp=round(t * S)) for t in (1.0, 2.0)
    )
    back = replace(first, sizes={'d': 0.0}, stddev={'d': 0.0}, retracted=True)
    for t, jumps in enumerate([(first,), (second, back), (replace(back, new=False),)], 3):
        history.add(estimate(float(t), jumps=jumps, drifting=('g',)))
    assert (history.jump_count, history.retraction_count) == (2, 1)
    assert history.jumps == [first, second, back] and history.standing == [second]
    assert history.drifting == {'g': 3}


def test_the_path_of_an_angle_lies_in_its_period():
    turn = 4.0
    states = (replace(VESSEL.states[0], period=turn),)
    history = History(replace(VESSEL, name='turning', states=states))
    path = np.array([[9.0], [7.0], [1.0]])
    history.add(estimate(2.0, 1.0, times=np.arange(3.0), states=path))
    assert history.path.rows[:, 0].tolist() == [1.0, -1.0, 1.0]
