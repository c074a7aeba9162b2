"""Tests of obs_ros.core.symbols: what is computed with symbols is recorded as NumPy would do it."""

import math
import operator
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from obs_ros.core.recorder import Recorder, Untraceable
from obs_ros.core.symbols import Symbol, is_symbolic, operand, select

X = np.array([-1.7, -0.5, 0.0, 0.3, 2.0])


def symbol(name: str = 'x') -> Symbol:
    return Symbol(Recorder(), name)


def value(found: Any, **names: Any) -> Any:
    """Return what the recorded operations come to."""
    texts: list[Any] = []
    for template, operands in found.recorder.nodes:
        text = template.format(*(texts[o] if isinstance(o, int) else o for o in operands))
        texts.append(f'({text})')
    text = texts[found.operand] if isinstance(found.operand, int) else found.operand
    return eval(text, {'np': np, **names})


TWO = [operator.add, operator.sub, operator.mul, operator.truediv, operator.floordiv,
       operator.mod, operator.lt, operator.le, operator.gt, operator.ge, operator.eq,
       operator.ne]  # fmt: skip


@pytest.mark.parametrize('operation', TWO)
def test_operators_from_either_side(operation: Callable[[Any, Any], Any]) -> None:
    with np.errstate(all='ignore'):
        np.testing.assert_array_equal(value(operation(symbol(), 0.3), x=X), operation(X, 0.3))
        np.testing.assert_array_equal(value(operation(0.3, symbol()), x=X), operation(0.3, X))


@pytest.mark.parametrize(
    'function',
    [
        abs, operator.neg, operator.pos, round, math.floor, math.ceil, math.trunc,
        lambda x: x**2, lambda x: 2.0**x,
    ],
)  # fmt: skip
def test_functions_of_one_number(function: Any) -> None:
    expected = [float(function(x)) for x in X.tolist()]
    np.testing.assert_array_equal(value(function(symbol()), x=X), expected)


def test_conditions_are_combined_and_count_as_numbers() -> None:
    x = symbol()
    both = (x > -1.0) & ~(x > 1.0)
    np.testing.assert_array_equal(value(both, x=X), [False, True, True, True, False])
    np.testing.assert_array_equal(value((x > 0.0) + (x > 1.0), x=X), [0, 0, 0, 1, 2])
    np.testing.assert_array_equal(value(select(x > 0.0, x, 1), x=X), [1, 1, 1, 0.3, 2.0])


def test_a_constant_0_or_1_makes_no_operation() -> None:
    x = symbol()
    assert all(operand(y) == 'x' for y in (0.0 + x, x - 0, 1 * x, x * 1.0, x / 1, x**1))
    assert (0.0 * x, x**0) == (0.0, 1.0)
    assert x.recorder.nodes == []


def test_arrays_of_symbols_are_numpys() -> None:
    x, y = (Symbol(Recorder(), name) for name in 'xy')
    y.recorder = x.recorder
    A = np.array([[2.0, 1.0], [0.0, 3.0]])
    first, second = A @ np.array([x, y]) + np.float64(1.0) * np.array([x, x])
    assert value(first, x=2.0, y=5.0) == 11.0
    assert value(second, x=2.0, y=5.0) == 17.0
    assert value(np.sin(np.array([x, y]))[1], x=2.0, y=5.0) == np.sin(5.0)
    assert value(np.sum([x, y, x]), x=2.0, y=5.0) == 9.0
    assert is_symbolic((1.0, [x])) and not is_symbolic((1.0, [2.0], A))


@pytest.mark.parametrize(
    ('misuse', 'cure'),
    [
        (lambda x: math.sin(x), "use NumPy's functions on values"),
        (lambda x: (1, 2)[x], 'no value as an index'),
        (lambda x: x + 1j, None),
        (lambda x: round(x, 3), 'use np.round without'),
        (lambda x: np.add.reduce(x), 'use a loop or sum'),
    ],
)
def test_what_cannot_be_recorded_is_refused_with_the_cure(misuse: Any, cure: str | None) -> None:
    with pytest.raises(Untraceable if cure else TypeError, match=cure):
        misuse(symbol())
