"""A replay beside another one of the same recording."""

import re

import numpy as np
import pytest
from ball_and_beam import made_up

from obs_ros import Sample
from obs_ros.replay.comparison import Other, alternative, comparison
from obs_ros.replay.engine import replay
from obs_ros.replay.settings import setup

GIVEN = {'model': 'ball_and_beam:BALL', 'window.duration': 5.0}
PUSH = 0.02  # m/sqrt(s), by which the position of the rig strays


@pytest.mark.parametrize(
    ('given', 'asked', 'found'),
    [
        ({}, None, 'process_noise:=off'),
        ({'process_noise': 'given'}, None, 'process_noise:=off'),
        ({'process_noise': 'off'}, None, 'process_noise:=auto'),
        ({}, ('window.duration', 10), 'window.duration:=10.0'),
        ({}, ('process_noise', False), 'process_noise:=off'),
        ({'observer': 'ekf'}, None, 'None'),
        ({'search.method': 'ga'}, None, 'None'),
    ],
)
def test_process_noise_is_compared_unless_another_parameter_is_asked_for(given, asked, found):
    given = {**GIVEN, **given}
    assert str(alternative(setup(given), given, asked)) == found


@pytest.mark.parametrize(
    ('asked', 'text'),
    [
        (('process_noise', 'auto'), 'give process_noise a value that the replay does not have'),
        (('windw.duration', 3.0), "there is no parameter 'windw.duration'"),
        (('model', 'three_tank'), 'replay another model by itself'),
        (('window.duration', -1.0), 'window.duration must be'),
        (('parameters', ['a']), 'b is not estimated and has no nominal value'),
    ],
)
def test_a_comparison_that_tells_nothing_is_refused(asked, text):
    with pytest.raises(ValueError, match=re.escape(text)):
        alternative(setup(GIVEN), GIVEN, asked)


def samples(t, u, y):
    for k in range(t.size):
        yield Sample(round(t[k] * 1e9), u=u[k : k + 1])
        yield Sample(round(t[k] * 1e9), y=y[k : k + 1])


def test_a_rig_that_is_pushed_about_is_told_with_process_noise_only():
    t, u, y = made_up(600, noise=2e-4)
    pushes = np.random.default_rng(2).normal(0.0, PUSH * np.sqrt(0.1), t.size)
    y = y + np.cumsum(pushes)  # a position that slides is no force
    chosen = setup(GIVEN)
    rival = alternative(chosen, GIVEN, None)
    accounts = [replay(each, samples(t, u, y)) for each in (chosen, rival.setup)]
    head, page, _ = comparison(chosen, accounts[0], Other(rival, accounts[1]))
    assert head == '## With another process_noise'
    rows = [line.strip('| ').split(' | ') for line in page.splitlines()]
    assert rows[0][-2:] == ['`process_noise` auto', '`process_noise` off']
    cells = {row[0]: row[1:] for row in rows[2:]}
    shares = [int(text.split(' of ')[0]) for text in cells['every sd given']]
    assert shares[0] >= 10 > shares[1]  # of 11; a parameter that seems to move has none
    assert [text.split(' ')[0] for text in cells['outcomes']] == ['converged', 'model_mismatch']
    foretold = cells['forecast of y (m) over an eighth of a window']
    near = [float(text.split(' ')[0]) for text in foretold]
    assert near[0] < 0.9 * near[1]
    walks = accounts[0].history.rows('walks')
    assert np.median(walks[walks[:, 0] > 0.0, 0]) == pytest.approx(PUSH, rel=0.3)
    assert not (accounts[1].history.rows('walks') > 0.0).any()


def test_observers_of_samples_are_compared_by_their_innovations():
    given = {'model': GIVEN['model'], 'observer': 'ekf', 'noise.y': 1e-4}
    chosen = setup(given)
    rival = alternative(chosen, given, ('noise.y', 1.0))
    accounts = [replay(each, samples(*made_up(100))) for each in (chosen, rival.setup)]
    head, page, note = comparison(chosen, accounts[0], Other(rival, accounts[1]))
    assert head == '## With another noise.y' and 'root mean squares' in note
    (row,) = [line for line in page.splitlines() if 'innovation' in line]
    near, far = (float(cell) for cell in row.strip('| ').split(' | ')[1:])
    assert near < 1e-2 < far
