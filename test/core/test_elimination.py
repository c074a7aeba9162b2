"""Tests of obs_ros.core.elimination: solutions, and the operations that zeros spare."""

import inspect
from typing import Any

import numpy as np
import pytest

from obs_ros.core.elimination import elimination, is_looped, operations, pivots

RNG = np.random.default_rng(11)


def matrices(n: int, places: Any, count: int) -> Any:
    """J (count, n, n), and its entries at the places."""
    J = np.zeros((count, n, n))
    for i, j in places:
        J[:, i, j] = RNG.standard_normal(count)
    return J, tuple(J[:, i, j] for i, j in places)


def chain(n: int) -> Any:
    return tuple((i, j) for i in range(n) for j in range(n) if abs(i - j) <= 1)


def arrow(n: int) -> Any:
    """All states act on the first, and the first on all."""
    return tuple((i, j) for i in range(n) for j in range(n) if i == j or 0 in (i, j))


@pytest.mark.parametrize('n', [1, 2, 3, 5, 8, 12, 16])
@pytest.mark.parametrize('density', [0.0, 0.3, 1.0])
def test_systems_of_every_structure_are_solved(n: int, density: float) -> None:
    places = tuple((i, j) for i in range(n) for j in range(n) if RNG.random() < density)
    J, entries = matrices(n, places, 30)
    r = RNG.standard_normal((n, 30))
    made = elimination(n, places, 2)
    c = 3.0 * n
    k = made.solved(made.factored(c, (None, None, *entries)), tuple(r))
    expected = np.linalg.solve(c * np.eye(n) - J, r.T[:, :, None])[:, :, 0]
    np.testing.assert_allclose(np.array(k).T, expected, rtol=1e-10, atol=1e-12)


@pytest.mark.parametrize('structure', [chain, arrow])
def test_operations_grow_in_proportion_to_the_states_where_zeros_allow_it(structure: Any) -> None:
    counts = []
    for n in (10, 20, 40):
        made = elimination(n, structure(n), 0)
        text = inspect.getsource(made.factored) + inspect.getsource(made.solved)
        counts.append(text.count('*') + text.count('/'))
    assert counts[1] - counts[0] == 60 and counts[2] - counts[1] == 120


def test_the_state_that_meets_all_others_is_eliminated_last() -> None:
    assert pivots(6, arrow(6))[-2:] in ([0, 5], [5, 0])


def test_loops_take_over_where_straight_line_code_would_be_long() -> None:
    full = {n: tuple((i, j) for i in range(n) for j in range(n)) for n in (8, 16)}
    assert not is_looped(8, full[8]) and is_looped(16, full[16])
    assert not is_looped(60, chain(60)) and operations(60, chain(60)) < 300
    assert operations(2, full[8][:1]) == 2


def test_one_structure_is_eliminated_once() -> None:
    assert elimination(4, chain(4), 4) is elimination(4, chain(4), 4)
