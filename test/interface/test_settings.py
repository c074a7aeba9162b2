"""Observers are made of a node's parameters."""

import math

import pytest

from obs_ros.interface.parameters import CHOICE, observer_parameters
from obs_ros.interface.settings import build_observer, differs
from obs_ros.models import load_model

TANKS = load_model('three_tank')


def values(observer, **given):
    rows = (*CHOICE, *observer_parameters(TANKS, observer))
    return {row.name: row.default for row in rows} | {'observer': observer, **given}


def test_only_what_is_given_reaches_an_observer_of_samples():
    given = {'noise.h1': 0.1, 'fixed.p2': 0.5, 'initial.h3': 44.0, 'bounds.p1': (0.1, 0.9)}
    observer = build_observer(TANKS, values('ekf', parameters=('p1',), **given))
    assert observer.unknowns.names == ('h1', 'h2', 'h3', 'p1')
    assert observer.immediate and observer.model is TANKS
    with pytest.raises(ValueError, match='p9'):
        build_observer(TANKS, values('ekf', parameters=('p9',)))


def test_steps_that_would_never_end_are_refused():
    build_observer(TANKS, values('sliding_window'))
    with pytest.raises(ValueError, match=r'^shorten window.duration or window.period'):
        build_observer(TANKS, values('sliding_window', **{'window.duration': 1e9}))


def test_only_changes_of_more_than_the_live_parameters_make_another_observer():
    before = values('sliding_window')
    assert not differs(before, before) and math.isnan(before['fixed.p1'])
    live = {'deadline': 9.0, 'stale_after': 9.0, 'prediction.enabled': False}
    assert not differs(before | live, before)
    assert differs(before | {'seed': 1}, before) and differs(before | {'fixed.p1': 0.5}, before)
