"""What a page gets of an estimator: panels, jumps and outcomes of the part that is seen."""

import json
import math

import numpy as np
import pytest

from obs_ros.core.estimate import Outcome
from obs_ros.interface.vectors import Vector
from obs_ros.pages.information import Information, Shown
from obs_ros.pages.observed import Observed
from obs_ros.pages.payload import Seen, good, number, numbers, payload

INFO = Information(
    'tank', 'ekf', states=(Shown('h', 'cm', 360.0),), inputs=(Shown('q'),),
    outputs=(Shown('h', 'cm'), Shown('w')), parameters=(Shown('p', '1/s'),),
)  # fmt: skip
ORIGIN = 10**18
SECOND = 10**9


@pytest.fixture
def observed():
    observed = Observed('/estimator', INFO)
    noise = np.random.default_rng(0).standard_normal((100, 2))
    for k, residual in enumerate(noise):
        stamp = ORIGIN + k * SECOND
        observed.hear(Vector('measured', stamp, {'h': float(k), 'w': math.nan}))
        observed.hear(Vector('residual', stamp, {'h': residual[0], 'w': 5.0}, effort=(1.0, 2.0)))
        if k % 10 == 0:
            for topic, name in (('state', 'h'), ('parameters', 'p')):
                observed.hear(Vector(topic, stamp, {name: 1.5}))
                observed.hear(Vector(f'{topic}_stddev', stamp, {name: 0.25}))
            observed.conclude(stamp, 'converged' if k < 50 else 'diverged', 'so')
    observed.hear(Vector('jump', ORIGIN + 42 * SECOND, {'p': -0.4}, (0.97,), (0.01,)))
    return observed


def panels(found):
    return {(panel['kind'], panel['name']): panel for panel in found['panels']}


def seen(begin=0, end=100, most=500):
    return Seen(ORIGIN + begin * SECOND, ORIGIN + end * SECOND, ORIGIN, most)


def test_panels_hold_curves_with_their_bands(observed):
    found = panels(payload(observed, seen()))
    assert [*found] == [
        ('parameter', 'p'), ('state', 'h'), ('output', 'w'), ('input', 'q'), ('residual', 'h'),
        ('residual', 'w'),
    ]  # fmt: skip
    (estimate,) = found['parameter', 'p']['curves']
    assert estimate['t'] == [10.0 * k for k in range(10)] and set(estimate['v']) == {1.5}
    assert set(estimate['band']['lower']) == {1.0} and set(estimate['band']['upper']) == {2.0}
    assert [curve['role'] for curve in found['state', 'h']['curves']] == ['measured', 'estimate']
    assert found['state', 'h']['period'] == 360.0
    # What was never measured has no curve.
    assert found['output', 'w']['curves'] == [] and found['input', 'q']['curves'] == []


def test_residuals_have_their_deviations_and_correlations(observed):
    found = panels(payload(observed, seen()))
    (curve,) = found['residual', 'w']['curves']
    assert set(curve['band']['upper']) == {4.0} and set(curve['band']['lower']) == {-4.0}
    white, constant = (found['residual', name]['correlation'] for name in ('h', 'w'))
    assert white['white'] is True and constant['white'] is False
    assert len(white['values']) == 25 and white['bound'] == pytest.approx(0.196)


def test_only_what_is_seen_is_told(observed):
    found = payload(observed, seen(45, 60))
    (measured, _) = panels(found)['state', 'h']['curves']
    assert measured['t'] == [float(k) for k in range(45, 61)]
    assert found['jumps'] == []
    assert [spell['outcome'] for spell in found['spells']] == ['diverged']
    assert found['outcome'] == {'outcome': 'diverged', 'message': 'so', 'good': 'no'}


def test_a_jump_is_told_in_words(observed):
    (jump,) = payload(observed, seen())['jumps']
    assert jump['t'] == 42.0 and jump['names'] == ['p'] and not jump['retracted']
    assert jump['words'] == 'p -0.4 ± 0.02'
    assert (jump['probability'], jump['probable']) == (0.97, 'probability 0.97')


def test_very_many_points_become_few(observed):
    (measured, _) = panels(payload(observed, seen(most=10)))['state', 'h']['curves']
    assert len(measured['t']) <= 20 and {0.0, 99.0} <= set(measured['v'])


def test_it_is_json_whatever_the_numbers(observed):
    observed.hear(Vector('residual', ORIGIN, {'h': math.inf, 'w': -math.inf}, effort=(0.0,)))
    observed.hear(Vector('state', ORIGIN + SECOND, {'h': math.nan}))
    observed.hear(Vector('jump', ORIGIN, {'p': math.inf}))
    json.dumps(payload(observed, seen()), allow_nan=False)


def test_numbers_keep_seven_digits():
    values = [0.0, 1.0 / 3.0, -2e-300, 12345678.9, 1e300, math.nan, math.inf, 5e-324]
    found = numbers(np.array(values))
    assert found[5:7] == [None, None]
    for value, kept in zip(values[:5], found[:5]):
        assert kept == pytest.approx(value, rel=1e-6, abs=0.0)
    assert number(math.pi) == 3.141593


def test_every_outcome_is_judged():
    assert {good(outcome) for outcome in Outcome} == {'yes', 'roughly', 'no'}
    assert good('what a stranger writes') == 'no'
