import math

import numpy as np
import pytest
from ball_and_beam import BALL, motion

from obs_ros import Estimate, Outcome, Sample
from obs_ros.replay.forecast import Forecaster

STEP = 10**8
T, U, Y, V = motion(120)


def estimate(k, r, v, a=5.0, b=0.3, c=0.1):
    state, parameters = {'r': r, 'v': v}, {'a': a, 'b': b, 'c': c}
    return Estimate(
        parameters=parameters, initial_state=state, state=state, stddev={},
        outcome=Outcome.CONVERGED, message='', t0=0.0, t1=T[k], stamp=k * STEP,
    )  # fmt: skip


def push(forecaster, first, last):
    for k in range(first, last):
        forecaster.push(Sample(k * STEP, u=U[k : k + 1]))
        forecaster.push(Sample(k * STEP, y=Y[k : k + 1]))


def test_the_truth_foretells_what_comes_and_no_sooner_than_it_has_come():
    forecaster = Forecaster(BALL, 2.0, 4.0, 1000)
    push(forecaster, 0, 31)
    forecaster.add(7, estimate(30, Y[30], V[30]))
    push(forecaster, 31, 50)
    assert forecaster.judge() == []
    push(forecaster, 50, 51)
    (forecast,) = forecaster.judge()
    assert forecast.index == 7
    assert forecast.rms[0] < 2e-4  # m: its integration is of second order only
    assert forecast.held[0] == pytest.approx(math.sqrt(np.mean((Y[31:51] - Y[30]) ** 2)))
    assert forecast.held[0] > 0.05
    # An eighth of 2 s holds two samples.
    assert forecast.near_held[0] == pytest.approx(math.sqrt(np.mean((Y[31:33] - Y[30]) ** 2)))
    assert 0.0 < forecast.near[0] <= forecast.rms[0]
    assert forecaster.judge() == []


def test_wrong_parameters_foretell_worse():
    errors = []
    for a in (5.0, 6.0):
        forecaster = Forecaster(BALL, 3.0, 6.0, 1000)
        push(forecaster, 0, 21)
        forecaster.add(0, estimate(20, Y[20], V[20], a=a))
        push(forecaster, 21, 60)
        errors.append(forecaster.judge()[0].rms[0])
    assert errors[1] > 10.0 * errors[0]


def test_overlapping_forecasts_are_judged_one_by_one():
    forecaster = Forecaster(BALL, 2.0, 4.0, 1000)
    judged = []
    for k in range(120):
        push(forecaster, k, k + 1)
        if k % 5 == 0:
            forecaster.add(k, estimate(k, Y[k], V[k]))
        judged += forecaster.judge()
    assert [f.index for f in judged] == list(range(0, 100, 5))
    assert max(f.rms[0] for f in judged) < 2e-4


def test_a_forecast_that_diverges_is_infinitely_wrong():
    forecaster = Forecaster(BALL, 2.0, 4.0, 1000)
    push(forecaster, 0, 11)
    forecaster.add(0, estimate(10, 0.0, 1e300, b=-1e3))
    push(forecaster, 11, 40)
    assert forecaster.judge()[0].rms[0] == math.inf


@pytest.mark.parametrize('value', [1e200, math.nan])
def test_what_the_observer_does_not_take_for_measured_is_not_compared(value):
    forecaster = Forecaster(BALL, 2.0, 4.0, 1000)
    push(forecaster, 0, 31)
    forecaster.add(0, estimate(30, Y[30], V[30]))
    forecaster.push(Sample(31 * STEP, y=np.array([value])))
    push(forecaster, 32, 60)
    (forecast,) = forecaster.judge()
    assert forecast.rms[0] < 2e-4
    assert forecast.held[0] == pytest.approx(math.sqrt(np.mean((Y[32:51] - Y[30]) ** 2)))


def test_a_new_timeline_ends_the_open_forecasts_and_none_of_its_samples_is_lost():
    forecaster = Forecaster(BALL, 2.0, 4.0, 1000)
    push(forecaster, 60, 91)
    forecaster.add(0, estimate(90, Y[90], V[90]))
    push(forecaster, 0, 5)
    forecaster.add(1, estimate(0, Y[0], V[0]))
    push(forecaster, 5, 40)
    (forecast,) = forecaster.judge()
    assert forecast.index == 1 and forecast.rms[0] < 2e-4


def test_memory_is_bounded_and_strays_do_not_count():
    forecaster = Forecaster(BALL, 2.0, 4.0, 10)
    push(forecaster, 0, 31)
    forecaster.add(0, estimate(30, Y[30], V[30]))
    forecaster.push(Sample(10**6 * STEP, y=np.zeros(1)))
    assert forecaster.judge() == []
    push(forecaster, 31, 60)
    assert forecaster.judge() == []  # its beginning had to go
    forecaster.forget()
    push(forecaster, 0, 5)
    forecaster.add(1, estimate(4, math.nan, 0.0))
    push(forecaster, 5, 40)
    assert forecaster.judge() == []
