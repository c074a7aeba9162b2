"""Observers are made of a node's parameters."""

import math
import re
from dataclasses import replace

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


KNOWN = {'walk.h1': 0.2, 'walk.p1': 0.01, 'prior.h1': (40.0, 2.0), 'prior.p2': (0.5, 0.05)}


@pytest.mark.parametrize('observer', ['sliding_window', 'ekf', 'ukf'])
def test_walks_and_priors_reach_those_who_take_them(observer):
    found = build_observer(TANKS, values(observer, **KNOWN)).model
    assert [v.walk for v in found.variables] == [0.2, None, None, 0.01, None, None]
    assert [v.prior for v in found.variables] == [(40.0, 2.0), None, None, None, (0.5, 0.05), None]
    assert build_observer(TANKS, values(observer)).model is TANKS


def test_what_the_model_has_can_be_taken_away():
    model = replace(TANKS, parameters=(
        replace(TANKS.parameters[0], walk=0.1, prior=(0.5, 0.1)), *TANKS.parameters[1:],
    ))  # fmt: skip
    rows = (*CHOICE, *observer_parameters(model, 'ekf'))
    given = {row.name: row.default for row in rows} | {'observer': 'ekf'}
    assert build_observer(model, given).model is model
    found = build_observer(model, given | {'walk.p1': 0.0, 'prior.p1': (0.0, 0.0)}).model
    assert (found.parameters[0].walk, found.parameters[0].prior) == (None, None)


@pytest.mark.parametrize(
    ('given', 'message'),
    [
        ({'prior.p1': (0.5, -0.1)}, 'p1: prior standard deviation -0.1 is not positive'),
        ({'prior.p1': (0.5, 0.0)}, 'p1: prior standard deviation 0.0 is not positive'),
        ({'prior.p1': (5.0, 0.1)}, 'p1: widen the bounds, or correct the prior: its mean 5.0'),
        ({'prior.p1': (0.5, 0.1), 'fixed.p1': 0.5}, 'p1 cannot have a prior: it is not estimated'),
    ],
)
@pytest.mark.parametrize('observer', ['sliding_window', 'ekf'])
def test_priors_that_do_not_go_with_the_rest_are_refused(observer, given, message):
    with pytest.raises(ValueError, match=f'^{re.escape(message)}'):
        build_observer(TANKS, values(observer, **given))


def test_a_given_walk_makes_process_noise_of_that_kind():
    with pytest.raises(ValueError, match="set process_noise to 'auto': 'given' finds none"):
        build_observer(TANKS, values('sliding_window', process_noise='given'))
    build_observer(TANKS, values('sliding_window', process_noise='given', **{'walk.h1': 0.1}))
