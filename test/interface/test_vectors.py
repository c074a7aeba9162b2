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
    Jump(
        5.0, 0.1, {name: -0.3, 'p2': 0.1}, {'p2': 0.02, name: 0.01}, new=new, stamp=5 * 10**9,
        probability=0.96,
    )
    for name, new in (('p1', False), ('p3', True))
)  # fmt: skip
ESTIMATE = Estimate(
    VALVES, LEVELS, LEVELS, {'h1': 0.5, 'p3': 0.01}, Outcome.CONVERGED, '', 0.0, 9.0, cost=2.0,
    residual_rms=0.1, evaluations=7, stamp=9 * 10**9, jumps=JUMPS, figures={'gain': 4.0},
    innovation={'h1': 0.2, 'h2': math.nan}, innovation_stddev={'h1': 0.1, 'h2': math.nan},
    interval={'h1': (0.0, 2.0), 'p3': (0.28, 0.34)},
)  # fmt: skip


def test_values_come_with_deviations_and_new_jumps_at_their_own_time():
    found = {v.topic: v for v in vectors(ESTIMATE, TANKS, {'skipped': 1.0})}
    assert set(found) == set(TOPICS)
    assert {v.stamp for topic, v in found.items() if topic != 'jump'} == {9 * 10**9}
    assert found['state'].values == LEVELS and found['parameters'].values == VALVES
    assert found['state_stddev'].values == pytest.approx(
        {'h1': 0.5, 'h2': math.nan, 'h3': math.nan}, nan_ok=True
    )
    assert found['jump'].stamp == 5 * 10**9
    assert found['residual'].values == ESTIMATE.innovation
    assert found['residual'].effort == (0.1, math.nan)
    assert found['solver'].values == {
        'cost': 2.0, 'residual_rms': 0.1, 'evaluations': 7.0, 'skipped': 1.0, 'gain': 4.0,
    }  # fmt: skip


def test_intervals_of_all_parameters_have_the_lower_end_as_value_and_the_upper_as_velocity():
    found = next(v for v in vectors(ESTIMATE, TANKS, {}) if v.topic == 'parameters_interval')
    assert list(found.values) == ['p1', 'p2', 'p3'] and found.stamp == 9 * 10**9
    lower, upper = [*found.values.values()], list(found.velocity)
    assert lower == pytest.approx([math.nan, math.nan, 0.28], nan_ok=True)
    assert upper == pytest.approx([math.nan, math.nan, 0.34], nan_ok=True)
    assert not found.effort


def test_a_new_jump_has_its_probability_as_velocity_and_deviations_as_effort():
    (found,) = (v for v in vectors(ESTIMATE, TANKS, {}) if v.topic == 'jump')
    assert list(found.values.items()) == [('p3', -0.3), ('p2', 0.1)]
    assert (found.velocity, found.effort) == ((0.96, 0.96), (0.01, 0.02))


def test_a_retraction_is_a_jump_of_no_size_at_its_time():
    nothing = {'p1': 0.0}
    back = Jump(
        4.0, 0.1, nothing, nothing, new=True, stamp=4 * 10**9, probability=0.01, retracted=True
    )
    told = dataclasses.replace(ESTIMATE, jumps=(back,))
    (found,) = (v for v in vectors(told, TANKS, {}) if v.topic == 'jump')
    assert found == ('jump', 4 * 10**9, {'p1': 0.0}, (0.01,), (0.0,))


def test_a_jump_of_unknown_deviation_and_probability_has_nan():
    bare = Jump(4.0, 0.1, {'p1': 0.2}, {}, new=True)
    told = dataclasses.replace(ESTIMATE, jumps=(bare,))
    (found,) = (v for v in vectors(told, TANKS, {}) if v.topic == 'jump')
    assert math.isnan(found.velocity[0]) and math.isnan(found.effort[0])


@pytest.mark.parametrize('wrong', [math.nan, math.inf])
def test_only_figures_come_of_an_estimate_that_is_not_finite(wrong):
    lost = dataclasses.replace(ESTIMATE, state={**LEVELS, 'h2': wrong})
    assert publishable(ESTIMATE) and not publishable(lost)
    assert [v.topic for v in vectors(lost, TANKS, {})] == ['solver']
