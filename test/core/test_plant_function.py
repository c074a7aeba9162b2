"""Tests of obs_ros.core.plant_function: functions as people write them, wrong ones named."""

import itertools
import re
from types import FunctionType
from typing import Any

import numpy as np
import pytest

from obs_ros import Model, Record, Variable, solve_window
from obs_ros.core.plant_function import PerCandidate, misplaced

RNG = np.random.default_rng(2)


def spring(dynamics: Any, **changes: Any) -> Model:
    settings: dict[str, Any] = {
        'name': 'spring',
        'states': [Variable('s', lower=-5.0, upper=5.0), Variable('v', lower=-9.0, upper=9.0)],
        'inputs': [Variable('f', lower=-1.0, upper=1.0)],
        'outputs': [Variable('y')],
        'parameters': [Variable('k', lower=1.0, upper=9.0), Variable('c', lower=0.1, upper=2.0)],
        'dynamics': dynamics,
        'output': lambda t, x, u, p: (x[0],),
        'max_step': 0.02,
    }
    return Model(**(settings | changes))


def scalars(t: Any, x: Any, u: Any, p: Any) -> Any:
    return x[1], np.clip(u[0], -0.5, 0.5) - p[0] * x[0] - p[1] * x[1]


def matrix(t: Any, x: Any, u: Any, p: Any) -> Any:
    A = np.array([[0.0, 1.0], [-p[0], -p[1]]])
    return A @ x + np.array([0.0, 1.0]) * max(-0.5, min(0.5, u[0]))


def until_settled(t: Any, x: Any, u: Any, p: Any) -> Any:
    force, step = u[0], 1.0
    while abs(step) > 1e-9:  # as often as it takes
        step = 0.5 * (min(max(force, -0.5), 0.5) - force)
        force += step
    return [x[1], force - p[0] * x[0] - p[1] * x[1]]


def window() -> Record:
    t = 0.05 * np.arange(81)
    u = np.sin(3.0 * t) + 0.5 * np.sin(7.0 * t)
    x, y = np.array([1.0, 0.0]), []
    for k in range(81):
        y.append(x[0] + 0.01 * RNG.standard_normal())
        for _ in range(50):
            x = x + 0.001 * np.array(scalars(0.0, x, (u[k],), (4.0, 0.6)))
    return Record(t, u, np.array(y))


def test_every_way_of_writing_gives_the_same_estimate() -> None:
    record = window()
    wanted, *others = (
        solve_window(spring(f), record, noise={'y': 0.01}, seed=1) for f in (scalars, matrix)
    )
    assert wanted.parameters['k'] == pytest.approx(4.0, abs=0.1)
    for found in others:
        assert found.outcome == wanted.outcome
        for name, value in wanted.parameters.items():
            assert found.parameters[name] == pytest.approx(value, rel=1e-6)
            assert found.stddev[name] == pytest.approx(wanted.stddev[name], rel=1e-4)


def test_a_straight_function_stays_itself_and_others_become_plain_ones() -> None:
    assert spring(scalars).dynamics is scalars
    made = spring(matrix).dynamics
    assert isinstance(made, FunctionType) and made is not matrix
    assert spring(made).dynamics is made
    x, u, p = RNG.uniform(0.0, 1.0, (2, 5)), RNG.uniform(-1.0, 1.0, (1, 5)), np.ones((2, 5))
    np.testing.assert_allclose(made(0.0, x, u, p), scalars(0.0, x, u, p), rtol=1e-12)


def test_sums_over_the_states_do_not_run_over_the_candidates() -> None:
    """Arrays pass for numbers in np.sum, which then adds all candidates."""
    made = spring(lambda t, x, u, p: (np.sum(x), np.dot(x, p))).dynamics
    x, p = np.arange(6.0).reshape(2, 3), np.ones((2, 3))
    np.testing.assert_array_equal(made(0.0, tuple(x), (0.0,), tuple(p)), [[3, 5, 7], [3, 5, 7]])


def test_what_cannot_be_recorded_runs_candidate_by_candidate() -> None:
    made = spring(until_settled).dynamics
    assert isinstance(made, PerCandidate)
    assert 'use np.where, or a loop of fixed length' in made.reason
    assert '`while abs(step) > 1e-9:' in made.reason
    x, u, p = RNG.uniform(0.0, 1.0, (2, 5)), RNG.uniform(-1.0, 1.0, (1, 5)), np.ones((2, 5))
    np.testing.assert_allclose(made(0.0, x, u, p), scalars(0.0, x, u, p), rtol=1e-6, atol=1e-8)
    assert np.shape(made(0.0, (1.0, 2.0), (0.1,), (1.0, 1.0))) == (2,)


def test_errors_of_values_make_nan_of_one_candidate() -> None:
    def dynamics(t: Any, x: Any, u: Any, p: Any) -> Any:
        until_settled(t, x, u, p)
        if x[0] > 4.9:
            raise ValueError('out of reach')
        return x[1], 1.0 / (x[0] - 0.5)

    found = np.array(
        spring(dynamics).dynamics(0.0, (np.array([0.5, 1.5, 5.0]), 0.0), (0.0,), (1.0, 1.0))
    )
    np.testing.assert_array_equal(found[1], [np.nan, 1.0, np.nan])


def test_a_function_with_a_memory_is_not_recorded() -> None:
    count = itertools.count()
    made = spring(lambda t, x, u, p: [x[1], float(next(count))]).dynamics
    assert isinstance(made, PerCandidate)
    assert made.reason.startswith('let results depend on t, x, u and p only: they differ')


@pytest.mark.parametrize(
    ('function', 'order'),
    [
        (lambda x, t, u, p: (x[1], x[0]), 'x, t, u, p'),
        (lambda t, x, p, u: (x[1], p[0]), 't, x, p, u'),
        (lambda x, u, p, t: (x[1], u[0]), 'x, u, p, t'),
        (lambda time, inputs, state, theta: (1.0, 2.0), 'time, inputs, state, theta'),
        (lambda x, u: (x[1], u[0]), 'x, u'),
    ],
)
def test_a_wrong_order_of_the_arguments_is_named(function: Any, order: str) -> None:
    words = f'dynamics must take (t, x, u, p) in this order, not ({order}) (test_plant_function.py'
    with pytest.raises(ValueError, match=re.escape(words)):
        spring(function)


@pytest.mark.parametrize(
    'function',
    [
        lambda t, x, u, p: None,
        lambda time, state, inputs, theta: None,
        lambda a, b, c, d: None,
        lambda t, y, u, k: None,
        lambda _t, x, u, p, x0=0.0: None,
        np.add,
    ],
)
def test_other_names_are_left_alone(function: Any) -> None:
    assert misplaced(function) == ''


def test_a_time_that_is_taken_for_the_state_is_told() -> None:
    with pytest.raises(ValueError, match=re.escape('(it is called with t, x, u, p)')):
        spring(lambda s, now, v, k: (s[1], s[0]))
