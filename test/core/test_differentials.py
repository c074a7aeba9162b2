"""Tests of obs_ros.core.differentials: operations that can be recorded, against differences."""

from typing import Any

import numpy as np
import pytest
from scipy import special

from obs_ros.core.derivatives import differentiated
from obs_ros.core.differentials import CHOICES, CONSTANT, PARTIALS

RNG = np.random.default_rng(5)
OUTSIDE = {
    'np.arccosh({})': (1.1, 3.0), 'np.arcsin({})': (-0.9, 0.9), 'np.arccos({})': (-0.9, 0.9),
    'np.arctanh({})': (-0.9, 0.9),
}  # fmt: skip
POSITIVE = 'log', 'sqrt', '**', 'power', 'gamma', 'reciprocal', ' / ', 'cbrt'
NUMBERS = {'np': np, 'special': special}


def points(template: str) -> Any:
    """Arguments (3, 40) at which an operation is smooth."""
    low, high = OUTSIDE.get(template, (0.3, 3.0) if _positive(template) else (-2.0, 2.0))
    return RNG.uniform(low, high, (3, 40))


def _positive(template: str) -> bool:
    return any(word in template for word in POSITIVE)


def operation(template: str, fixed: dict[int, float] | None = None) -> Any:
    """The operation on states, as a plant's function; some operands are constants instead."""
    names = [
        repr(fixed[i]) if fixed and i in fixed else f'x[{i}]' for i in range(template.count('{}'))
    ]
    scope: dict[str, Any] = dict(NUMBERS)
    exec(f'def f(t, x, u, p):\n    return {template.format(*names)}, 0.0, 0.0\n', scope)
    return scope['f']


def slopes(f: Any, x: Any) -> Any:
    """The rows (3, 40) of the recorded derivative."""
    made = differentiated(f, 3, 0, 0)
    found = made.function(0.0, 1.0, tuple(x), (), (), ())
    rows = np.zeros(x.shape)
    for (_, j), entry in zip(made.places, found[3:], strict=True):
        rows[j] = entry
    return rows


def differences(f: Any, x: Any, d: float = 1e-6) -> Any:
    rows = []
    for j in range(3):
        above, below = x.copy(), x.copy()
        above[j] += d
        below[j] -= d
        rows.append((f(0.0, above, (), ())[0] - f(0.0, below, (), ())[0]) / (2.0 * d))
    return np.array(rows)


@pytest.mark.parametrize('template', [t for t in (*PARTIALS, *CHOICES) if 'where' not in t])
def test_derivatives_are_those_of_differences(template: str) -> None:
    f, x = operation(template), points(template)
    np.testing.assert_allclose(slopes(f, x), differences(f, x), rtol=1e-6, atol=1e-7)


def test_of_two_branches_the_one_that_is_taken_counts() -> None:
    def f(t: Any, x: Any, u: Any, p: Any) -> Any:
        return np.where(x[0] > 0.5, np.sin(x[1]), x[2] * x[2]), 0.0, 0.0

    x = points('')
    np.testing.assert_allclose(slopes(f, x), differences(f, x), rtol=1e-6, atol=1e-7)


@pytest.mark.parametrize('template', sorted(CONSTANT - {'np.heaviside({}, {})'}))
def test_steps_and_conditions_do_not_change(template: str) -> None:
    f = operation(template)
    with np.errstate(all='ignore'):
        x = points(template)
        assert not slopes(lambda t, x, u, p: (f(t, x, u, p)[0] + 0.0, 0.0, 0.0), x).any()


@pytest.mark.parametrize(
    ('template', 'fixed'),
    [('{} ** {}', {1: 2}), ('{} ** {}', {1: 3.0}), ('{} ** {}', {1: -2}), ('{} ** {}', {1: 0.5}),
     ('{} ** {}', {1: 1.5}), ('{} ** {}', {1: 1.3}), ('{} ** {}', {1: -0.7}), ('{} ** {}', {1: 70}),
     ('{} ** {}', {0: 2.0}), ('{} / {}', {0: 3.0}), ('np.maximum({}, {})', {1: 0.5}),
     ('np.clip({}, {}, {})', {1: -0.5, 2: 0.5}), ('{} % {}', {1: 0.7})],
)  # fmt: skip
def test_constants_among_the_operands(template: str, fixed: dict[int, float]) -> None:
    f, x = operation(template, fixed), points(template)
    np.testing.assert_allclose(slopes(f, x), differences(f, x), rtol=1e-6, atol=1e-7)


@pytest.mark.parametrize(
    'text',
    ['np.sqrt(x[0])', 'np.cbrt(x[0])', 'np.sqrt(np.maximum(x[0], 0.0))', 'x[0] ** 0.5',
     'np.hypot(x[0], x[1])', 'np.arctan2(x[0], x[1])', 'np.sign(x[0]) * np.sqrt(np.abs(x[0]))',
     'np.sinc(x[0])', 'np.arcsin(1.0 - x[0])', 'np.arccosh(1.0 + x[0])', 'x[0] ** x[1]'],
)  # fmt: skip
def test_where_a_value_is_finite_its_derivative_is(text: str) -> None:
    scope: dict[str, Any] = dict(NUMBERS)
    exec(f'def f(t, x, u, p):\n    return {text}, 0.0, 0.0\n', scope)
    with np.errstate(all='ignore'):
        assert np.isfinite(slopes(scope['f'], np.zeros((3, 4)))).all()


def test_every_function_of_numpy_that_can_be_recorded_has_a_derivative() -> None:
    known = {*PARTIALS, *CHOICES, *CONSTANT}
    for name in dir(np):
        ufunc = getattr(np, name)
        real = isinstance(ufunc, np.ufunc) and 'd' * ufunc.nin + '->d' in ufunc.types
        if real and ufunc.nout == 1 and ufunc.signature is None and ufunc.__name__ == name:
            arguments = ', '.join(f'x[{i}]' for i in range(ufunc.nin))
            scope: dict[str, Any] = dict(NUMBERS)
            exec(f'def f(t, x, u, p):\n    return np.{name}({arguments}), 0.0, 0.0\n', scope)
            assert differentiated(scope['f'], 3, 0, 0).exact, name
    assert len(known) > 60
