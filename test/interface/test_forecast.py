"""Tests of obs_ros.interface.forecast."""

import numpy as np
import pytest
from plants import VESSEL

from obs_ros import Estimate, Outcome, Sample
from obs_ros.interface.forecast import Forecast, window_reach

S = 10**9
VALUES = {
    'prediction.rate': 0.0, 'window.duration': 60.0, 'window.period': 0.0, 'process_noise': 'off',
    'loss': 'robust',
}  # fmt: skip


def forecast(**values):
    published = []
    found = Forecast(VESSEL, lambda one: published.append((one.stamp / S, one.state['x'])))
    found.follow({**VALUES, **values})
    return found, published


def estimate(t):
    return Estimate(
        parameters={'d': 1.0, 'g': 0.0}, initial_state={'x': 0.0}, state={'x': 0.0}, stddev={},
        outcome=Outcome.CONVERGED, message='', t0=0.0, t1=t, stamp=round(t * S),
    )  # fmt: skip


def outputs(found, *times, silent=False):
    """x' = 1 from the estimate on."""
    for t in times:
        found.absorb(Sample(round(t * S), u=np.zeros(1)), 0.0, silent=lambda: silent)
        found.absorb(Sample(round(t * S), y=np.zeros(1)), 0.0, silent=lambda: silent)


def test_every_output_after_an_estimate_is_predicted_to():
    found, published = forecast()
    outputs(found, 0, 1)
    assert not published and found.horizon is None
    found.start(estimate(1.0))
    outputs(found, 2, 3)
    assert published == [(2.0, pytest.approx(1.0)), (3.0, pytest.approx(2.0))]
    assert (found.published, found.horizon) == (2, 2.0) and found.latency > 0.0


def test_the_rate_is_one_of_sample_time():
    found, published = forecast(**{'prediction.rate': 0.5})
    outputs(found, 0)
    found.start(estimate(0.0))
    outputs(found, 1, 2, 3, 4, 5)
    assert [t for t, _ in published] == [1, 3, 5]


def test_the_rate_is_kept_on_a_timeline_that_begins_anew():
    found, published = forecast(**{'prediction.rate': 0.5})
    outputs(found, 1000)
    found.start(estimate(1000.0))
    outputs(found, 1001, *range(10))
    found.start(estimate(9.0))
    outputs(found, 10, 11, 12)
    assert [t for t, _ in published] == [1001, 10, 12]


def test_silence_is_asked_after_only_where_there_is_something_to_say():
    found, _ = forecast(**{'prediction.rate': 0.5})
    asked = []

    def silent():
        asked.append(1)
        return False

    outputs(found, 0)
    found.start(estimate(0.0))
    for t in (1, 2, 3):
        found.absorb(Sample(t * S, u=np.zeros(1)), 0.0, silent=silent)
        found.absorb(Sample(t * S, y=np.zeros(1)), 0.0, silent=silent)
    assert len(asked) == found.published == 2  # at 1 and 3 s


def test_one_that_is_to_be_silent_goes_on_unseen():
    found, published = forecast()
    outputs(found, 0)
    found.start(estimate(0.0))
    outputs(found, 1, 2, silent=True)
    outputs(found, 3)
    assert published == [(3.0, pytest.approx(3.0))]


@pytest.mark.parametrize(('period', 'goes_on'), [(0.0, True), (20.0, False)])
def test_it_goes_on_over_a_gap_that_the_window_goes_on_over(period, goes_on):
    found, published = forecast(**{'window.period': period})
    outputs(found, *(0.01 * k for k in range(50)))
    found.start(estimate(0.49))
    outputs(found, *(100.49 + k for k in range(6)))
    assert bool(published) == goes_on
    if goes_on:
        assert published[-1] == (105.49, pytest.approx(105.0))


def test_it_ends_with_the_observers_timeline_but_keeps_its_samples():
    found, published = forecast()
    outputs(found, 0, 1)
    found.start(estimate(1.0))
    outputs(found, 2)
    found.end()
    outputs(found, 3)
    assert found.horizon is None and len(published) == 1
    found.start(estimate(2.0))
    outputs(found, 4)
    assert published[1] == (4.0, pytest.approx(2.0))
    found.forget()
    found.start(estimate(3.0))
    outputs(found, 5)
    assert len(published) == 2


def test_abutting_windows_reach_two_durations():
    assert window_reach(VALUES) == 120.0
    assert window_reach({**VALUES, 'window.period': 10.0}) == 70.0
