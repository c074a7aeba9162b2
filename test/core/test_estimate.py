"""Tests of obs_ros.core.estimate."""

import ast
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import obs_ros
from obs_ros import Estimate, Outcome
from obs_ros.core.estimate import Jump, normal_intervals


def estimate(**changes: Any) -> Estimate:
    values: dict[str, Any] = {
        'parameters': {'p': 1.0},
        'initial_state': {'x': 2.0},
        'state': {'x': 3.0},
        'stddev': {'x': np.nan, 'p': np.nan},
        'outcome': Outcome.CONVERGED,
        'message': 'two rounds agree',
        't0': 0.0,
        't1': 1.0,
    }
    return Estimate(**(values | changes))


def test_outcomes_are_the_words_of_the_contract() -> None:
    assert {str(outcome) for outcome in Outcome} == {
        'converged', 'approximate', 'deadline', 'not_identifiable', 'at_bound', 'model_mismatch',
        'too_few_samples', 'stale_output', 'stale_input', 'diverged',
    }  # fmt: skip


def test_usable_without_standard_deviations() -> None:
    assert estimate().usable
    assert estimate(parameters={}).usable


@pytest.mark.parametrize('field', ['parameters', 'initial_state', 'state'])
@pytest.mark.parametrize('value', [np.nan, np.inf])
def test_not_usable_with_a_value_that_is_not_finite(field: str, value: float) -> None:
    assert not estimate(**{field: {'name': value}}).usable


def test_intervals_of_normal_distributions_reach_1_96_deviations_to_both_sides() -> None:
    found = normal_intervals({'x': 3.0, 'p': 1.0, 'q': 7.0}, {'x': 0.5, 'p': np.nan, 'q': 0.0})
    assert found['x'] == pytest.approx((3.0 - 0.98, 3.0 + 0.98))
    assert np.isnan(found['p']).all(), 'not determined'
    assert found['q'] == (7.0, 7.0), 'given'


def test_without_deviations_nothing_says_how_far_the_values_hold() -> None:
    values = {'x': 3.0, 'p': 1.0}
    stddev = {'x': 0.5, 'p': 0.25}
    told = estimate(
        stddev=stddev,
        initial_stddev={'x': 0.1},
        interval=normal_intervals(values, stddev),
        covariance=np.eye(2),
    )
    withheld = told.without_deviations()
    assert list(withheld.stddev) == list(withheld.interval) == ['x', 'p']
    assert np.isnan([*withheld.stddev.values(), *withheld.initial_stddev.values()]).all()
    assert np.isnan(list(withheld.interval.values())).all()
    assert withheld.covariance.size == 0
    assert (withheld.state, withheld.parameters) == (told.state, told.parameters)
    assert np.isfinite(list(told.interval.values())).all()


def test_whoever_changes_deviations_changes_the_intervals_too() -> None:
    alone = []
    for path in Path(obs_ros.__file__).parent.rglob('*.py'):
        for node in ast.walk(ast.parse(path.read_text('utf-8'))):
            if isinstance(node, ast.Call) and getattr(node.func, 'id', '') in (
                'replace',
                'Estimate',
            ):
                named = {keyword.arg for keyword in node.keywords}
                if 'stddev' in named and 'interval' not in named:
                    alone.append(f'{path}:{node.lineno}')
    assert not alone


def jump(**changes: Any) -> Jump:
    values: dict[str, Any] = {
        'time': 5.0,
        'time_stddev': 0.1,
        'sizes': {'k1': -0.3, 'k2': 12.0},
        'stddev': {'k1': 0.01, 'k2': 0.5},
        'new': True,
    }
    return Jump(**(values | changes))


@pytest.mark.parametrize(
    ('probability', 'said'),
    [(np.nan, ''), (0.97, ', probability 0.97'), (0.997, ', probability > 0.99')],
)
def test_a_jump_says_sizes_with_two_deviations_and_its_probability(
    probability: float, said: str
) -> None:
    expected = 'jump at 5.00 s +- 0.2 s: k1 -0.3 +- 0.02, k2 +12 +- 1'
    assert str(jump(probability=probability)) == f'{expected}{said}'


def test_a_jump_that_is_taken_back_says_so() -> None:
    nothing = {'k1': 0.0, 'k2': 0.0}
    back = jump(sizes=nothing, stddev=nothing, probability=0.02, retracted=True)
    assert str(back) == 'jump at 5.00 s taken back: k1, k2'


@pytest.mark.parametrize(
    ('changes', 'retracted', 'expected'),
    [
        ({}, True, True),
        ({}, False, False),
        ({'sizes': {'k1': 1.0}}, True, True),
        ({'sizes': {'k3': 1.0}}, True, False),
        ({'time': 5.01}, True, False),
    ],
    ids=['its own', 'an announcement', 'a part', 'another', 'at another time'],
)
def test_a_retraction_takes_back_a_jump_of_its_names_at_its_time(
    changes: dict[str, Any], retracted: bool, expected: bool
) -> None:
    back = jump(sizes={'k1': 0.0, 'k2': 0.0}, retracted=retracted)
    assert back.takes_back(jump(**changes)) == expected


def test_estimates_compare_by_identity_since_they_hold_arrays() -> None:
    one, other = (estimate(times=np.arange(3.0), states=np.zeros((3, 1))) for _ in range(2))
    assert one == one and one != other
    assert len({one, other, one}) == 2


def test_a_retraction_takes_back_what_was_announced() -> None:
    announced = jump(stamp=5 * 10**9, alternatives=('k3',))
    retraction = announced.taken_back(0.1)
    assert retraction.takes_back(announced) and retraction.new and retraction.retracted
    assert retraction.sizes == {'k1': 0.0, 'k2': 0.0} == retraction.stddev
    assert (retraction.time, retraction.stamp) == (5.0, 5 * 10**9)
    assert (retraction.probability, retraction.alternatives) == (0.1, ())
