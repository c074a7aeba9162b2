"""Tests of obs_ros.core.tracing: straight-line code for functions with loops and branches."""

import inspect
from typing import Any

import numpy as np
import pytest

from obs_ros.core.fingerprint import fingerprint
from obs_ros.core.recorder import LIMITS, Untraceable
from obs_ros.core.tracing import traced, unpacked

RNG = np.random.default_rng(3)
X = tuple(RNG.uniform(-2.0, 2.0, (3, 60)))
P = tuple(RNG.uniform(0.5, 2.0, (2, 60)))


def same(function: Any, entries: int, vectors: Any = tuple) -> Any:
    """Hold the recorded function against the function of each candidate; return it."""
    made = traced(function, (3, 0, 2), entries, vectors)
    found = np.array([np.broadcast_to(e, 60) for e in made(0.5, X, (), P)])
    expected = [
        np.ravel(function(0.5, vectors(x), (), vectors(p)))
        for x, p in zip(np.array(X).T.tolist(), np.array(P).T.tolist(), strict=True)
    ]
    np.testing.assert_allclose(found.T, expected, rtol=1e-12)
    return made


def test_operations_keep_their_order_and_shared_ones_have_a_name() -> None:
    def f(t: Any, x: Any, u: Any, p: Any) -> Any:
        shared = np.sin(x[0]) * p[0]
        return np.array([shared + x[1], shared - t])

    made = traced(f, (2, 0, 1), 2, tuple)
    assert inspect.getsource(made) == (
        'def f(t, x, u, p):\n    v1 = np.sin(x[0]) * p[0]\n    return ((v1 + x[1]), (v1 - t),)\n'
    )


def test_loops_slices_and_matrices() -> None:
    A = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [-1.0, -2.0, -3.0]])

    def f(t: Any, x: Any, u: Any, p: Any) -> Any:
        total = 0.0
        for i, each in enumerate(x[1:]):
            total += (i + 1) * each
        return [*(A @ x)[1:], total, sum(p), *np.diff(x)]

    same(f, 6)


def test_branches_on_values_become_selects() -> None:
    def f(t: Any, x: Any, u: Any, p: Any) -> Any:
        a, b, c = x
        if a > 1.0 and b > 0.0:
            return [a, b]
        if not c < 0.0 or a < -1.0:
            b = -b
        for each in p:
            if each > 1.0:
                b += each
        count = 0
        while count < 3 and c > count - 1:
            count += 1
        return [min(a, b, c) * (1.0 if c > 0 else 2.0), b / (1 + count)]

    made = same(f, 2)
    assert 'if' not in inspect.getsource(made)


def test_ten_tanks_that_spill_leave_ten_selects() -> None:
    def f(t: Any, x: Any, u: Any, p: Any) -> Any:
        rates = []
        for i in range(9):
            spilt = 0.0
            if x[i] > 1.0:
                spilt = x[i] - 1.0
            rates.append(p[0] * np.sqrt(x[i]) - 0.1 * spilt)
        return rates

    made = traced(f, (9, 0, 1), 9, tuple)
    assert inspect.getsource(made).count('np.where') == 9


def test_a_way_that_raises_is_nan() -> None:
    def f(t: Any, x: Any, u: Any, p: Any) -> Any:
        if x[0] < 0.0:
            raise ValueError('below the ground')
        return (x[0] * 2,)

    (found,) = traced(f, (1, 0, 0), 1, tuple)(0.0, (np.array([-1.0, 2.0]),), (), ())
    np.testing.assert_array_equal(found, [np.nan, 4.0])


def test_whole_vectors() -> None:
    same(lambda t, x, u, p: -x[::-1] * p[0] + np.array([1.0, 0.0, p[1]]), 3, np.array)


def test_whole_numbers_that_are_selected_stay_exponents() -> None:
    same(lambda t, x, u, p: [abs(x[0]) ** (-1 if x[1] > 0 else 2)], 1)


@pytest.mark.parametrize(
    ('body', 'words'),
    [
        (lambda x: [x[0] if any(x[0] > k for k in range(600)) else 0], 'use np.where, or a loop'),
        (lambda x: [sum(np.sin(k * x[0]) for k in range(5000))], f'than {LIMITS.operations} op'),
        (lambda x: [np.interp(x[0], np.arange(99.0), np.arange(99.0))], 'a table of more than 64'),
        (lambda x: [np.linalg.solve(np.eye(9), [x[0]] * 9)[0]], 'systems of 8 equations'),
    ],
)
def test_what_is_too_much_is_refused(body: Any, words: str) -> None:
    with pytest.raises(Untraceable, match=words):
        traced(lambda t, x, u, p: body(x), (1, 0, 0), 1, tuple)


@pytest.mark.parametrize('returned', [3.0, {1.0}, np.zeros((2, 1)), (1.0,), None])
def test_what_is_no_vector_of_two_is_refused(returned: Any) -> None:
    with pytest.raises(TypeError, match='return a tuple, a list or an array of 2 numbers'):
        unpacked(returned, 2)


def test_equal_code_has_one_fingerprint_and_other_constants_another() -> None:
    def scaled(k: float) -> Any:
        return traced(lambda t, x, u, p: [k * x[0]], (1, 0, 0), 1, tuple)

    assert fingerprint('', scaled(2.0)) == fingerprint('', scaled(2.0))
    assert fingerprint('', scaled(2.0)) != fingerprint('', scaled(2.5))
