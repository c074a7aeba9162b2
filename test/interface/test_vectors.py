"""Named vectors of an estimate."""

import dataclasses
import math

import pytest

from obs_ros.core.estimate import Estimate, Jump, Outcome
from obs_ros.interface.vectors import TOPICS, publishable, vectors
from obs_ros.models import load_model

TANKS = load_model('three_tank')
LEVELS, VALVES = {'h1': 1.0, 'h2': 2.0, 'h3': 3.0}, {'p1': 0.1, 'p2': 0.2, 'p3': 0.3}
JUMPS = tuple(
    Jump(5.0, 0.1, {name: -0.3}, {name: 0.01}, new=new, stamp=5 * 10**9)
    for name, new in (('p1', False), ('p3', True))
)
ESTIMATE = Estimate(
    VALVES, LEVELS, LEVELS, {'h1': 0.5, 'p3': 0.01}, Outcome.CONVERGED, '', 0.0, 9.0, cost=2.0,
    residual_rms=0.1, evaluations=7, stamp=9 * 10**9, jumps=JUMPS, figures={'gain': 4.0},
    innovation={'h1': 0.2, 'h2': math.nan}, innovation_stddev={'h1': 0.1, 'h2': math.nan},
)  # fmt: skip


def test_values_come_with_deviations_and_new_jumps_at_their_own_time():
    found = {v.topic: v for v in vectors(ESTIMATE, TANKS, {'skipped': 1.0})}
    assert set(found) == set(TOPICS)
    assert {v.stamp for topic, v in found.items() if topic != 'jump'} == {9 * 10**9}
    assert found['state'].values == LEVELS and found['parameters'].values == VALVES
    assert found['state_stddev'].values == pytest.approx(
        {'h1': 0.5, 'h2': math.nan, 'h3': math.nan}, nan_ok=True
    )
    assert found['jump'] == ('jump', 5 * 10**9, {'p3': -0.3}, ())
    assert found['residual'] == ('residual', 9 * 10**9, ESTIMATE.innovation, (0.1, math.nan))
    assert found['solver'].values == {
        'cost': 2.0, 'residual_rms': 0.1, 'evaluations': 7.0, 'skipped': 1.0, 'gain': 4.0,
    }  # fmt: skip


@pytest.mark.parametrize('wrong', [math.nan, math.inf])
def test_only_figures_come_of_an_estimate_that_is_not_finite(wrong):
    lost = dataclasses.replace(ESTIMATE, state={**LEVELS, 'h2': wrong})
    assert publishable(ESTIMATE) and not publishable(lost)
    assert [v.topic for v in vectors(lost, TANKS, {})] == ['solver']
