"""Tests of obs_ros.core.derivatives: what is computed, and of functions that are not recorded."""

import inspect
from typing import Any

import numpy as np
import pytest
from plants import OSCILLATOR
from scipy.special import expit

from obs_ros import Model, Variable
from obs_ros.core.derivatives import by_differences, differentiated, linearisation
from obs_ros.core.plant_function import PerCandidate
from obs_ros.core.recorder import LIMITS
from obs_ros.models import MODELS, load_model

RNG = np.random.default_rng(7)


def robertson(t: Any, x: Any, u: Any, p: Any) -> Any:
    a, b, c = x
    back, apart = p[1] * b * c, p[2] * b * b
    return -p[0] * a + back, p[0] * a - back - apart, apart


def test_only_entries_that_are_not_zero_are_computed() -> None:
    made = differentiated(robertson, 3, 0, 3)
    assert made.places == ((0, 0), (0, 1), (0, 2), (1, 0), (1, 1), (1, 2), (2, 1))
    assert made.moving == ()
    x, p = (0.7, 2e-5, 0.3), (0.04, 1e4, 3e7)
    found = made.function(0.0, 1.0, x, (), (), p)
    np.testing.assert_allclose(found[:3], robertson(0.0, x, (), p), rtol=1e-14)
    expected = [-0.04, 3e3, 0.2, 0.04, -3e3 - 1.2e3, -0.2, 1.2e3]
    np.testing.assert_allclose(found[3:], expected, rtol=1e-13)


def test_what_the_function_computes_already_is_shared() -> None:
    made = differentiated(lambda t, x, u, p: (np.exp(x[0]) * x[1], x[0]), 2, 0, 0)
    assert inspect.getsource(made.function).count('np.exp') == 1


def test_time_counts_by_itself_and_through_inputs() -> None:
    def f(t: Any, x: Any, u: Any, p: Any) -> Any:
        return np.sin(t) * x[0], u[0] * u[1] * p[0], x[2]

    made = differentiated(f, 3, 2, 1)
    assert made.moving == (0, 1)
    found = made.function(0.3, 1.0, (2.0, 0.0, 0.0), (3.0, 4.0), (0.5, -1.0), (10.0,))
    assert found[-2:] == pytest.approx((np.cos(0.3) * 2.0, 10.0 * (4.0 * 0.5 - 3.0)))


def dense(model: Model, made: Any, x: Any, u: Any, p: Any) -> Any:
    """f (n, B), the whole Jacobian (n, n, B) and the derivative in time (n, B)."""
    n, count = len(x), x.shape[1]
    v = tuple(np.linspace(-1.0, 1.0, len(u)))
    found = [np.broadcast_to(e, count) for e in made.function(0.2, 1e-3, tuple(x), u, v, p)]
    jacobian, drift = np.zeros((n, n, count)), np.zeros((n, count))
    for (i, j), entry in zip(made.places, found[n:], strict=False):
        jacobian[i, j] = entry
    for i, entry in zip(made.moving, found[n + len(made.places) :], strict=True):
        drift[i] = entry
    return np.array(found[:n]), jacobian, drift


@pytest.mark.parametrize('name', MODELS)
def test_built_in_models_have_exact_derivatives(name: str) -> None:
    model = load_model(name)
    sizes = len(model.states), len(model.inputs), len(model.parameters)
    made = linearisation(model.dynamics, *sizes)
    assert made.exact
    near = [
        [max(v.lower, -9.0), min(v.upper, 9.0)] if v.nominal is None else [v.nominal] * 2
        for v in (*model.states, *model.inputs, *model.parameters)
    ]
    low, high = np.array(near, dtype=np.float64).T
    values = low[:, None] + (high - low)[:, None] * RNG.uniform(0.4, 0.6, (low.size, 6))
    x, u, p = np.split(values, np.cumsum(sizes)[:2])
    exact = dense(model, made, x, tuple(u), tuple(p))
    differenced = by_differences(model.dynamics, *sizes[:2])
    for ours, theirs in zip(exact, dense(model, differenced, x, tuple(u), tuple(p)), strict=True):
        size = np.abs(ours).max() + 1e-30
        np.testing.assert_allclose(ours, theirs, rtol=2e-4, atol=2e-5 * size)


def test_one_function_is_differentiated_once() -> None:
    assert linearisation(OSCILLATOR.dynamics, 2, 1, 2) is linearisation(
        OSCILLATOR.dynamics, 2, 1, 2
    )


def logistic(t: Any, x: Any, u: Any, p: Any) -> Any:
    return -expit(x[0]) + u[0], x[0] - p[0] * x[1] ** 2 + t


def test_differences_stand_in_for_functions_that_cannot_be_recorded() -> None:
    made = linearisation(logistic, 2, 1, 1)
    assert not made.exact and len(made.places) == 4
    x = (np.array([0.5, 0.0, -3.0]), np.array([1.0, 0.0, 30.0]))
    found = made.function(1.0, 0.01, x, (2.0,), (5.0,), (3.0,))
    sigma = expit(x[0])
    expected = [-sigma + 2.0, x[0] - 3.0 * x[1] ** 2 + 1.0, -sigma * (1 - sigma), 0.0 * sigma,
                1.0 + 0.0 * sigma, -6.0 * x[1], 5.0 + 0.0 * sigma, 1.0 + 0.0 * sigma]  # fmt: skip
    for ours, exact in zip(found, expected, strict=True):
        np.testing.assert_allclose(ours, exact, rtol=1e-6, atol=2e-6)


def test_a_function_that_runs_candidate_by_candidate_has_differences() -> None:
    def f(t: Any, x: Any, u: Any, p: Any) -> Any:
        return [float(-2.0 * each) for each in x]

    single = PerCandidate(f, 2, tuple, 'float')
    made = linearisation(single, 2, 0, 0)
    found = made.function(0.0, 1.0, (np.ones(3), np.zeros(3)), (), (), ())
    np.testing.assert_allclose(np.array(found[2:6])[:, 1], [-2.0, 0.0, 0.0, -2.0], atol=1e-6)


def test_derivatives_of_too_many_operations_are_replaced_by_differences() -> None:
    def f(t: Any, x: Any, u: Any, p: Any) -> Any:
        total = 0.0
        for i in range(LIMITS.operations // 4):
            total = np.sin(total + (i + 1.0) * x[i % 10])
        return [total + each for each in x]

    assert not linearisation(f, 10, 0, 0).exact


def test_models_of_all_kinds_can_be_linearised_as_they_are_recorded() -> None:
    def f(t: Any, x: Any, u: Any, p: Any) -> Any:
        rates = [-p[0] * each for each in x]
        if x[0] > 1.0:
            rates[1] += x[0] * x[0]
        return np.array(rates)

    model = Model('m', [Variable('a'), Variable('b')], [Variable('y')], f,
                  lambda t, x, u, p: (x[0],), parameters=[Variable('k')])  # fmt: skip
    made = linearisation(model.dynamics, 2, 0, 1)
    found = made.function(0.0, 1.0, (np.array([0.5, 2.0]), 1.0), (), (), (3.0,))
    assert made.places == ((0, 0), (1, 0), (1, 1))
    np.testing.assert_allclose(found[3], [0.0, 4.0])
