"""Tests of obs_ros.core.elementary: NumPy's values in extended precision, and its special ones."""

import itertools
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from obs_ros import Model, Record, Variable
from obs_ros.core.elementary import ELEMENTARY
from obs_ros.core.typing import Array
from obs_ros.integration.grid import Grid
from obs_ros.integration.vectorised import NumpyKernels

pytest.importorskip('numba')

TWO = ('arctan2', 'power', 'hypot')
NAMES = list(ELEMENTARY)
TINY = 5e-324  # the smallest number, spacing of those next to zero
SPECIAL = (
    0.0, -0.0, 1.0, -1.0, 0.5, -0.5, 2.0, -2.0, 3.0, -3.0, math.pi, -math.pi, math.nan, math.inf,
    -math.inf, TINY, -TINY, 1e-310, -1e-310, 2.0**53 + 2.0, 1e10, -1e10, 1e300, -1e300,
    709.7827, 709.79, -745.13, -745.14, -708.5, 1.0 + 2.0**-52, 1.0 - 2.0**-53,
)  # fmt: skip
ANGLES = 2.0**48  # beyond which sin, cos and tan are NaN
NUMBERS = np.random.default_rng(3)


def of(functions: list[str], method: Any = 'rk4') -> Model:
    """Every state stays where it is; each output is a function of them."""

    def output(t: Any, x: Any, u: Any, p: Any) -> Any:
        return [
            getattr(np, name)(*x) if name in TWO else getattr(np, name)(x[0]) for name in functions
        ]

    return Model(
        name='functions',
        states=(Variable('a', lower=0.2, upper=1.7), Variable('b', lower=0.2, upper=1.7)),
        outputs=tuple(map(Variable, functions)),
        parameters=(),
        dynamics=lambda t, x, u, p: (0.0, 0.0),
        output=output,
        integrator=method,
    )


def compiled(a: Array, b: Array) -> dict[str, Array]:
    from obs_ros.integration.compiled import CompiledKernels

    model, count = of(NAMES), len(NAMES)
    grid = Grid.of(model, Record([0.0, 1.0], None, np.zeros((2, count))), np.ones(count))
    _, found = CompiledKernels(model).trajectories(grid, np.array([a, b]), np.zeros((0, a.size)))
    return dict(zip(NAMES, found[0], strict=True))


def true(name: str, a: Array, b: Array) -> Any:
    arguments = [each.astype(np.longdouble) for each in ((a, b) if name in TWO else (a,))]
    with np.errstate(all='ignore'):
        return getattr(np, name)(*arguments)


def check(a: Array, b: Array, rtol: float = 1e-12) -> None:
    for name, found in compiled(a, b).items():
        expected = true(name, a, b)
        with np.errstate(all='ignore'):
            rounded = expected.astype(np.float64)
        if name in ('sin', 'cos', 'tan'):
            rounded = np.where(np.abs(a) < ANGLES, rounded, np.nan)
        np.testing.assert_array_equal(np.isnan(found), np.isnan(rounded), name)
        finite = np.isfinite(rounded)
        np.testing.assert_array_equal(found[~finite], rounded[~finite], name)
        error = np.abs(found[finite].astype(np.longdouble) - expected[finite])
        limit = rtol * np.abs(expected[finite]) + TINY
        if name == 'power':  # the logarithm's last places count as often as its power says
            limit = limit * (1.0 + 1e-3 * np.abs(np.log(np.abs(expected[finite]) + TINY)))
        worst = int(np.argmax(error - limit)) if error.size else 0
        assert (error <= limit).all(), (name, a[finite][worst], b[finite][worst])


@pytest.mark.parametrize(
    ('low', 'high'), [(-323.0, -280.0), (-320.0, 0.0), (-3.0, 1.5), (0.0, 3.0), (1.0, 308.0)]
)
def test_values_are_numpys_to_a_few_units_in_the_last_place(low: float, high: float) -> None:
    a, b = 10.0 ** NUMBERS.uniform(low, high, (2, 20_000))
    signs = NUMBERS.choice([-1.0, 1.0], (2, a.size))
    check(signs[0] * a, signs[1] * b, 8e-16)


def test_near_their_zeros_poles_and_limits_too() -> None:
    one = 1.0 + NUMBERS.uniform(-1e-6, 1e-6, 4000)
    turns = np.arange(-6000.0, 6000.0) * (np.pi / 4.0)
    ends = np.concatenate([NUMBERS.uniform(709.0, 710.0, 2000), -NUMBERS.uniform(700, 750, 2000)])
    whole = np.arange(-2000.0, 2000.0)
    a = np.concatenate([one, turns, 1e6 * turns, ends, 10.0 * NUMBERS.standard_normal(4000)])
    b = np.concatenate([1e6 * whole, turns, turns[::-1], ends[::-1], whole])
    check(a, b)


def test_special_values_are_numpys() -> None:
    a, b = np.array([*itertools.product(SPECIAL, SPECIAL)]).T
    check(a, b)


def test_the_sign_of_zero_tells_the_side_of_an_angle() -> None:
    found = compiled(np.array([0.0, -0.0, 0.0, -0.0]), np.array([-1.0, -1.0, -0.0, -0.0]))
    np.testing.assert_array_equal(found['arctan2'], [np.pi, -np.pi, np.pi, -np.pi])


def oscillator(function: Callable[..., Any], method: Any) -> Model:
    def dynamics(t: Any, x: Any, u: Any, p: Any) -> Any:
        return x[1], -p[0] * x[0] - 0.05 * function(x[1])

    return Model(
        name='oscillator',
        states=(Variable('a', lower=-2, upper=2), Variable('b', lower=-2, upper=2)),
        outputs=(Variable('a'),),
        parameters=(Variable('k', lower=0.5, upper=2),),
        dynamics=dynamics,
        output=lambda t, x, u, p: (x[0],),
        max_step=0.05,
        integrator=method,
    )


@pytest.mark.parametrize('method', ['rk4', 'rosenbrock'])
def test_compiled_steps_of_all_functions_agree_with_numpys(method: Any) -> None:
    from obs_ros.integration.compiled import CompiledKernels

    def together(v: Any) -> Any:
        w = 0.9 * np.sin(v)
        s = np.arcsin(w) + np.arccos(0.9 * np.cos(v)) + np.tanh(v) + np.tan(w) + np.arctan(v)
        s = s + np.arctan2(v, 1.0 + v * v) + np.exp(w) + np.expm1(w)
        s = s + np.log(1.0 + v * v) + np.log1p(v * v) + np.hypot(v, 1.0)
        return s + np.power(2.0 + w, w) + (1.0 + w * w) ** 1.3 + (1.0 + w) ** 1.5 + 2.0**w

    model = oscillator(together, method)
    t = 0.05 * np.arange(60)
    grid = Grid.of(model, Record(t, None, np.zeros((60, 1))), np.ones(1))
    x0, p = NUMBERS.uniform(-2.0, 2.0, (2, 48)), NUMBERS.uniform(0.5, 2.0, (1, 48))
    found, expected = (
        kernels(model).trajectories(grid, x0, p)[0] for kernels in (CompiledKernels, NumpyKernels)
    )
    np.testing.assert_allclose(found, expected, rtol=1e-9)
