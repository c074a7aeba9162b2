import dataclasses

import numpy as np
import pytest
from plants import tank_record

from obs_ros.core.estimate import Estimate, Outcome
from obs_ros.horizon.probation import (
    EARNED,
    SKILLED,
    Probation,
    withheld_by_push,
    without_stuck,
)
from obs_ros.models.three_tank import THREE_TANK


def found(t1: float) -> Estimate:
    return Estimate(
        parameters={'p': 1.0}, initial_state={'x': 2.0}, state={'x': 3.0},
        stddev={'x': 0.1, 'p': 0.2}, initial_stddev={'x': 0.1}, outcome=Outcome.CONVERGED,
        message='as told', t0=0.0, t1=t1, covariance=np.eye(2),
        interval={'x': (2.8, 3.2), 'p': (0.6, 1.4)},
    )  # fmt: skip


def test_windows_that_fit_from_the_start_are_trusted():
    probation = Probation()
    for k, fits in enumerate((True, False, True)):
        estimate = found(k)
        assert probation.judge(estimate, fits) is estimate


def test_after_a_first_window_that_does_not_fit_trust_is_earned_by_many_in_a_row():
    probation = Probation()
    estimate = found(10.0)
    assert probation.judge(estimate, False) is estimate, 'it says so itself'
    for k in range(EARNED):
        doubted = probation.judge(found(20.0 + k), True)
        assert doubted.outcome is Outcome.MODEL_MISMATCH and not doubted.jumps
        assert 'the window that ended at 10 s contradicted the model' in doubted.message
        assert np.isnan([*doubted.stddev.values(), *doubted.initial_stddev.values()]).all()
        assert np.isnan(list(doubted.interval.values())).all()
        assert doubted.state == {'x': 3.0} and doubted.covariance.size == 0
    assert probation.judge(estimate, True) is estimate
    probation.judge(found(1.0), False)
    assert probation.judge(estimate, True) is estimate, 'once earned, it stays'


def test_trust_is_earned_by_twenty_in_a_row():
    probation = Probation()
    probation.judge(found(0.0), False)
    outcomes = [probation.judge(found(1.0 + k), True).outcome for k in range(21)]
    assert outcomes == [*[Outcome.MODEL_MISMATCH] * 20, Outcome.CONVERGED]


def test_doubt_starts_anew_with_every_window_that_does_not_fit():
    probation = Probation()
    for k in range(EARNED):
        probation.judge(found(k), k not in (0, EARNED - 1))
    assert 'ended at 19 s' in probation.judge(found(99.0), True).message


@pytest.mark.parametrize('scale', [None, np.array([0.01, 0.01])])
def test_what_is_stuck_is_taken_out_and_the_stamp_goes_with_the_newest_left(scale):
    record = tank_record(nodes=101)
    y = record.y.copy()
    y[40:, 0] = y[40, 0]
    sound = without_stuck(THREE_TANK, record.with_outputs(y), {}, scale)
    assert sound.stale and sound.repeated == 61 and 'h1 repeats the same value' in sound.said
    assert (
        np.isnan(sound.record.y[40:, 0]).all()
        and sound.record.y[40:, 1].tolist() == y[40:, 1].tolist()
    )


def test_a_sensor_that_says_something_again_is_not_stale():
    record = tank_record(nodes=101)
    y = record.y.copy()
    y[40:60, 0] = 0.0
    sound = without_stuck(THREE_TANK, record.with_outputs(y), {}, np.array([0.01, 0.01]))
    assert sound.repeated == 20 and not sound.stale
    np.testing.assert_array_equal(np.isnan(sound.record.y[:, 0]), y[:, 0] == 0.0)


def test_nothing_left_is_no_record():
    record = tank_record(nodes=101)
    rest = record.with_outputs(np.tile([3.0, 4.0], (101, 1)))
    given = {'h1': 0.01, 'h2': 0.01}
    assert without_stuck(THREE_TANK, rest, given, None).record is None
    assert without_stuck(THREE_TANK, rest, {}, None).record is rest
    # Learned from a simulation without noise, it is rounding.
    assert without_stuck(THREE_TANK, rest, {}, np.array([1e-9, 1e-9])).record is rest


def test_a_record_with_other_outputs_has_the_stamp_of_the_newest():
    record = tank_record(nodes=11)
    stamped = type(record)(record.t, record.u, record.y, stamp=10**10)
    y = record.y.copy()
    y[8:] = np.nan
    assert stamped.with_outputs(y).stamp == 7 * 10**9
    assert record.with_outputs(y).stamp is None


def test_forecasts_that_beat_holding_earn_trust_sooner():
    probation = Probation()
    for k in range(SKILLED - 1):
        doubted = probation.judge(found(10.0 * k), False, 0.9)
        assert doubted.outcome is Outcome.APPROXIMATE
        assert f'{SKILLED - 1 - k} more windows whose forecasts beat' in doubted.message
        assert np.isnan(list(doubted.stddev.values())).all()
    for estimate in (found(50.0), found(60.0)):
        assert probation.judge(estimate, False, 0.9) is estimate
    assert probation.judge(estimate, True) is estimate


def test_forecasts_that_do_not_begin_anew():
    probation = Probation()
    for skill in (0.9, 0.2, -0.1, 0.9, 0.1):
        judged = probation.judge(found(10.0), False, skill)
        assert np.isnan(list(judged.stddev.values())).all()
        assert judged.outcome is (Outcome.APPROXIMATE if skill > 0.0 else Outcome.CONVERGED)
    assert probation.judge(found(20.0), True).outcome is Outcome.MODEL_MISMATCH


def test_noise_that_nobody_gave_is_not_contradicted():
    probation, estimate = Probation(), found(10.0)
    assert probation.judge(estimate, False, 0.9, given=False) is estimate
    assert probation.judge(estimate, True, given=False) is estimate, 'nor doubted afterwards'


def test_process_noise_out_of_nothing_takes_deviations_and_confidence():
    doubted = withheld_by_push(found(10.0))
    assert doubted.outcome is Outcome.APPROXIMATE
    assert np.isnan([*doubted.stddev.values(), *doubted.initial_stddev.values()]).all()
    assert doubted.message.startswith('look for a fault') and doubted.message.endswith('(as told)')
    at_bound = dataclasses.replace(found(10.0), outcome=Outcome.NOT_IDENTIFIABLE)
    assert withheld_by_push(at_bound).outcome is Outcome.NOT_IDENTIFIABLE
