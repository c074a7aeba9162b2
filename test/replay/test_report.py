"""The report of a replay: what the node would have published, in one file of bounded size."""

import functools
import json
import re

import numpy as np
import pytest
from ball_and_beam import motion

from obs_ros.core.record import Sample
from obs_ros.replay import report
from obs_ros.replay.engine import replay
from obs_ros.replay.report import Report
from obs_ros.replay.settings import setup

NOISE = 0.001  # m
T, U, R, V = motion(160)
Y = R + NOISE * np.random.default_rng(1).standard_normal(T.size)


def samples():
    for t, u, value in zip(T, U, Y):
        stamp = round(t * 1e9)
        yield Sample(stamp, u=np.array([u]))
        yield Sample(stamp, y=np.array([value]))


@functools.cache
def reported(**values):
    given = {'model': 'ball_and_beam:BALL', 'window.duration': 5.0, 'window.period': 2.5, **values}
    chosen = setup(given)
    made = Report(chosen)
    account = replay(chosen, made.heard(samples()), take=made.take)
    text = made.text('rig <b>', account, ['a remark'])
    (stored,) = re.findall(r'id="data">(.*)</script>\n<script>', text)
    return account, text, json.loads(stored)


def curves(found):
    return {
        (panel['kind'], panel['name'], curve['role']): curve
        for panel in found['shown'][0]['panels'] for curve in panel['curves']
    }  # fmt: skip


def test_it_shows_estimates_predictions_and_residuals_as_the_node_publishes_them():
    account, text, found = reported()
    history, shown = account.history, curves(found)
    np.testing.assert_allclose(shown['output', 'y', 'measured']['v'], Y, rtol=1e-5, atol=1e-9)
    estimate = shown['parameter', 'a', 'estimate']
    assert estimate['t'] == [5.0, 7.5, 10.0, 12.5, 15.0]
    n = len(history.model.states)
    value, sd = (history.rows(kind)[:, n] for kind in ('values', 'deviations'))
    np.testing.assert_allclose(estimate['v'], value, rtol=1e-6)
    np.testing.assert_allclose(estimate['band']['upper'], value + 2.0 * sd, rtol=1e-6)
    # Every output after the first window is predicted.
    predicted, residual = shown['state', 'r', 'prediction'], shown['residual', 'y', 'residual']
    assert predicted['t'] == residual['t'] == [round(t, 6) for t in T[T > 5.0 + 1e-9]]
    assert np.std(residual['v']) == pytest.approx(NOISE, rel=0.5)
    assert found['notes'] == ['a remark']
    assert '<title>Replay of rig &lt;b&gt;</title>' in text and '5 estimates' in text


def test_without_predictions_it_has_none():
    _, _, found = reported(**{'prediction.enabled': False})
    roles = {role for _, _, role in curves(found)}
    assert 'estimate' in roles and not {'prediction', 'residual'} & roles


def test_estimates_are_the_same_with_and_without_it():
    account, _, _ = reported()
    chosen = setup({
        'model': 'ball_and_beam:BALL', 'window.duration': 5.0, 'window.period': 2.5,
    })  # fmt: skip
    plain = replay(chosen, samples())
    for kind in ('values', 'deviations'):
        np.testing.assert_array_equal(account.history.rows(kind), plain.history.rows(kind))


def test_its_size_has_a_bound(monkeypatch):
    whole = len(reported()[1])
    monkeypatch.setattr(report, 'SETTINGS', report.ReportSettings(points=1000, most=2000, least=10))
    _, text, found = reported.__wrapped__()
    assert len(text) < whole
    assert all(len(curve['t']) <= 2 * 1000 // 10 for curve in curves(found).values())


def test_what_came_before_a_new_timeline_is_told_to_be_missing():
    chosen = setup({'model': 'ball_and_beam:BALL', 'window.duration': 5.0})
    made = Report(chosen)
    again = (Sample(s.stamp + shift, u=s.u, y=s.y) for shift in (10**12, 0) for s in samples())
    account = replay(chosen, made.heard(again), take=made.take)
    assert any('start anew' in note for note in account.notes)
    text = made.text('twice', account)
    assert 'that stamps went far back, which is not shown: that was so 1 time(s)' in text


def test_an_empty_recording_has_a_report_too():
    chosen = setup({'model': 'ball_and_beam:BALL', 'window.duration': 5.0})
    made = Report(chosen)
    account = replay(chosen, made.heard([]), take=made.take)
    assert '0 estimates' in made.text('nothing', account)
