"""Tests of obs_ros.core.substitutes: functions of NumPy, math and Python on recorded numbers."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import scipy.special

from obs_ros.core.tracing import traced

RNG = np.random.default_rng(5)
X = RNG.uniform(-2.0, 2.0, (4, 50))


def both(function: Callable[..., Any]) -> tuple[Any, Any]:
    """Return a function of x (4,) over candidates as recorded, and of each candidate as written."""
    recorded = traced(lambda t, x, u, p: [function(x)], (4, 0, 0), 1, tuple)
    (found,) = recorded(0.0, tuple(X), (), ())
    return found, np.array([function(tuple(x)) for x in X.T.tolist()], dtype=float)


MATRIX = [[2.0, 1.0, 0.0], [0.5, -3.0, 1.0], [0.0, 1.0, 4.0]]


@pytest.mark.parametrize(
    'function',
    [
        lambda x: math.sin(x[0]) + math.atan2(x[1], x[2]) + math.hypot(*x[:3]),
        lambda x: math.log(2.5 + x[0]) + math.log(3.0 + x[1], 2) + math.log1p(abs(x[2])),
        lambda x: math.erf(x[0]) + math.gamma(3.0 + x[1]) + scipy.special.erfc(x[2]),
        lambda x: math.floor(x[0]) + math.fmod(x[1], 0.7) + math.copysign(2.0, x[2]),
        lambda x: min(x) + max(x[0], 0.3) + min([x[1], x[2]]) + max(x, key=abs),
        lambda x: sum(x) + sum(a * b for a, b in zip(x, x[::-1], strict=True)) + float(x[1]),
        lambda x: np.min(x) + np.max(np.array(x)) + np.amax(x[:2]),
        lambda x: np.clip(x[0], -1, 1) + np.clip(x, None, 0.5)[1] + np.clip(x[2], 0.1, None),
        lambda x: np.clip(a=x[0], a_min=x[1] - 3.0, a_max=1.5),
        lambda x: np.where(x[0] > 0, x[1], 2) + np.where(np.array(x) > 0, x, 0.0)[3],
        lambda x: np.select([x[0] > 1, x[0] > 0], [x[1], x[2]], 5.0),
        lambda x: np.heaviside(x[0], 0.5) + np.sign(x[1]) + np.round(3 * x[2]),
        lambda x: np.sinc(x[0]) + np.nan_to_num(x[1]) + np.logaddexp(x[2], x[3]),
        lambda x: np.interp(x[0], [-1.0, 0.0, 1.5], [3.0, -1.0, 2.0]),
        lambda x: np.interp(x[0], np.array([-1.0, 0.0]), [x[1], x[2]]),
        lambda x: np.dot(x, x) + np.linalg.norm(x) + np.outer(x, x)[1, 2] + np.mean(x),
        lambda x: np.cross(x[:3], [1.0, 2.0, x[3]])[1] + np.polyval([1.0, x[1], 2.0], x[0]),
        lambda x: np.linalg.solve(np.array(MATRIX) + np.diag(x[:3]), x[1:])[0],
        lambda x: np.linalg.inv(np.array([[x[0], 1.0], [2.0, x[1]]]) + np.eye(2))[0, 1],
        lambda x: np.piecewise(x[0], [x[0] > 0.5], [1.0, 2.0]),
        lambda x: (x[0] > 0) * x[1] + np.logical_and(x[2] > 0, x[3] < 1) + np.isfinite(x[0]),
    ],
)
def test_recorded_functions_compute_what_they_compute_of_numbers(function: Any) -> None:
    np.testing.assert_allclose(*both(function), rtol=1e-12, atol=1e-12)


def test_arrays_made_of_floats_take_symbols() -> None:
    def filled(x: Any) -> Any:
        found = np.zeros((2, 2))
        found[0, 1] = x[0]
        counts = np.ones(2, dtype=int)
        counts[0] += 1
        return (found @ x[:2])[0] + np.full_like(np.array(x), x[1])[2] * counts[0]

    np.testing.assert_allclose(*both(filled), rtol=1e-12)


def test_nan_lets_a_table_return_nan() -> None:
    recorded = traced(
        lambda t, x, u, p: [np.interp(x[0], [0, 1, 2], [3, 4, 6])], (1, 0, 0), 1, tuple
    )
    (found,) = recorded(0.0, (np.array([-9.0, 1.5, 9.0, np.nan]),), (), ())
    np.testing.assert_array_equal(found, [3.0, 5.0, 6.0, np.nan])


def test_without_symbols_each_function_is_the_original() -> None:
    def constants(x: Any) -> Any:
        numbers = (min(3, 1), max([1.0, 2.0]), float('2.5'), isinstance(2.0, float))
        assert numbers == (1, 2.0, 2.5, True)
        assert np.zeros(2, dtype=int).dtype == int
        return x[0] * np.interp(0.5, [0.0, 1.0], [0.0, 2.0]) * math.sqrt(4.0)

    np.testing.assert_allclose(*both(constants), rtol=1e-12)
