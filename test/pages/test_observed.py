"""What is heard of one estimator, in whatever order it comes."""

import math

import numpy as np
import pytest

from obs_ros.interface.vectors import Vector
from obs_ros.pages.information import Information, Shown
from obs_ros.pages.observed import MOST_JUMPS, MOST_SPELLS, WAITING, Observed

INFO = Information(
    'tank', 'sliding_window', states=(Shown('h', 'cm'),), inputs=(Shown('q'),),
    outputs=(Shown('h', 'cm'), Shown('w')), parameters=(Shown('p'), Shown('r')),
)  # fmt: skip
EVER = (-(2**62), 2**62)


@pytest.fixture
def observed():
    return Observed('/estimator', INFO)


def rows(observed, topic):
    return observed.traces[topic].raw(*EVER)[1].tolist()


@pytest.mark.parametrize('first', ['parameters', 'parameters_stddev'])
def test_values_and_deviations_meet_whichever_comes_first(observed, first):
    both = {'parameters': {'r': 2.0, 'p': 1.0}, 'parameters_stddev': {'p': 0.1, 'r': 0.5}}
    for topic in sorted(both, key=lambda name: name != first):
        observed.hear(Vector(topic, 7, both[topic]))
    assert rows(observed, 'parameters') == [[1.0, 0.8, 1.2, 2.0, 1.0, 3.0]]
    assert observed.newest == observed.oldest == 7


def test_values_without_deviations_come_when_many_wait(observed):
    for k in range(WAITING + 1):
        observed.hear(Vector('state', k, {'h': float(k)}))
    (row,) = rows(observed, 'state')
    assert row[0] == 0.0 and math.isnan(row[1])


def test_deviations_without_values_are_bounded(observed):
    for k in range(3 * WAITING):
        observed.hear(Vector('state_stddev', k, {'h': 1.0}))
    assert len(observed._pairings['state'].deviations) == WAITING
    assert rows(observed, 'state') == []


@pytest.mark.parametrize('ahead', ['prediction', 'prediction_stddev'])
def test_messages_that_are_lost_cost_a_band_or_a_value_and_nothing_else(observed, ahead):
    """However many are lost, and whichever of both topics is read first, some at once."""
    count, block = 4 * WAITING, 50
    for begin in range(0, count, block):
        stamps = range(begin, begin + block)
        both = {
            'prediction': [Vector('prediction', k, {'h': float(k)}) for k in stamps if k % 7],
            'prediction_stddev': [
                Vector('prediction_stddev', k, {'h': 0.5}) for k in stamps if k % 3
            ],
        }
        for topic in sorted(both, key=lambda name: name != ahead):
            for vector in both[topic]:
                observed.hear(vector)
    found, row = observed.traces['prediction'].raw(*EVER)
    assert observed.begun_anew == 0 and found.size >= 600
    assert found.tolist() == [k for k in range(count) if k % 7][-found.size :]
    np.testing.assert_array_equal(row[:, 0], found)
    assert [math.isnan(low) for low in row[:, 1]] == [k % 3 == 0 for k in found]


def test_names_are_sought_and_further_ones_left_alone(observed):
    observed.hear(Vector('measured', 1, {'w': 2.0, 'other': 3.0}))
    np.testing.assert_array_equal(rows(observed, 'measured'), [[math.nan, 2.0]])
    observed.hear(Vector('residual', 1, {'w': 0.3, 'h': 0.1}, effort=(3.0, 1.0)))
    assert rows(observed, 'residual') == [[0.1, 1.0, 0.3, 3.0]]
    observed.hear(Vector('solver', 1, {'solve_time_s': 0.25, 'unknown': 1.0}))
    assert rows(observed, 'solver')[0][0] == 0.25
    observed.hear(Vector('no such topic', 1, {'h': 1.0}))


def test_a_plant_that_starts_again_begins_anew(observed):
    for k in range(200):
        observed.hear(Vector('measured', k, {'h': 1.0}))
    observed.hear(Vector('applied', 190, {'q': 1.0}))
    observed.conclude(150, 'converged', '')
    observed.hear(Vector('measured', 0, {'h': 2.0}))
    assert observed.begun_anew == 1 and observed.newest == 0
    assert rows(observed, 'measured')[0][0] == 2.0
    assert not observed.spells and rows(observed, 'applied') == []


def test_jumps_are_kept_and_taken_back(observed):
    jump = Vector('jump', 50_000, {'p': -0.4}, (0.97,), (0.01,))
    observed.hear(jump)
    observed.hear(jump._replace(stamp=90_000))
    observed.hear(jump._replace(values={'nobody': 1.0}))
    observed.hear(Vector('jump', 50_001, {'p': 0.0, 'r': 0.0}, (0.1, 0.1), (0.0, 0.0)))
    first, second = observed.jumps
    assert first.retracted and not second.retracted
    assert (first.sizes, first.stddev, first.probability) == ({'p': -0.4}, {'p': 0.01}, 0.97)
    for k in range(2 * MOST_JUMPS):
        observed.hear(jump._replace(stamp=1000 * k))
    assert len(observed.jumps) == MOST_JUMPS


def test_runs_of_an_outcome_are_one_spell(observed):
    for stamp, outcome in ((1, 'converged'), (2, 'converged'), (2, 'converged'), (3, 'deadline')):
        observed.conclude(stamp, outcome, f'at {stamp}')
    first, second = observed.spells
    assert (first.begin, first.end, first.count, first.message) == (1, 2, 2, 'at 2')
    assert (second.outcome, second.count) == ('deadline', 1)
    for k in range(4, 3 * MOST_SPELLS):
        observed.conclude(k, f'outcome {k}', 'x\n' * 5000)
    assert len(observed.spells) == MOST_SPELLS
    assert len(observed.spells[-1].message) <= 2000 and '\n' not in observed.spells[-1].message
