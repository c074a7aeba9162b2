"""Tests of obs_ros.core.selects: NumPy's results."""

import itertools
import logging
import math
import re
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy import maximum, where
from plants import BLOW_UP
from scipy import special
from scipy.special import expit

from obs_ros import Model, Record, Variable
from obs_ros.core.selects import SELECTS
from obs_ros.integration.backends import kernels_for
from obs_ros.integration.grid import Grid
from obs_ros.integration.vectorised import NumpyKernels

FLOATS = (math.nan, -math.inf, -2.5, -1.0, 0.0, 1.0, 2.5, math.inf)
NUMBERS = (*FLOATS, -3, 0, 2)
TWO = (np.minimum, np.maximum, np.fmin, np.fmax)


@pytest.mark.parametrize('function', [*TWO, np.heaviside], ids=lambda f: f.__name__)
def test_functions_of_two_numbers_are_numpys(function: Callable[..., Any]) -> None:
    for a, b in itertools.product(NUMBERS, NUMBERS):
        np.testing.assert_equal(SELECTS[function](a, b), function(a, b), f'{a}, {b}')


def test_sign_is_numpys() -> None:
    for number in NUMBERS:
        np.testing.assert_equal(SELECTS[np.sign](number), np.sign(number), f'{number}')


def test_where_picks_as_numpy_does() -> None:
    for condition in (True, False, *NUMBERS):
        for a, b in itertools.product((math.nan, 1.0, 2, True), repeat=2):
            picked = SELECTS[np.where](condition, a, b)
            np.testing.assert_equal(picked, np.where(condition, a, b)[()])


@pytest.mark.parametrize(
    ('low', 'high'),
    [(-1.0, 1.0), (1.0, -1.0), (0, None), (None, 1), (math.nan, 1.0), (-1, math.nan)],
)
def test_clip_is_numpys_whatever_its_bounds_are_called(low: Any, high: Any) -> None:
    clip = SELECTS[np.clip]
    for number in NUMBERS:
        expected = np.clip(number, low, high)
        for found in (
            clip(number, low, high),
            clip(number, a_min=low, a_max=high),
            clip(number, min=low, max=high),
        ):
            np.testing.assert_equal(found, expected, f'{number}')


def clip(x: Any) -> Any:  # called like the function that it uses
    return np.clip(x, 0, 1)


FLOOR = -1


# Every state stays where it is; each output is one way to choose.
def output(t: Any, x: Any, u: Any, p: Any) -> Any:
    a, b = x
    (c,) = p
    return (
        np.where(a > b, a, c),
        np.where(a > 0, 1, 0.5) * b,
        np.where(a > 0, True, False) * b,
        np.where(a, b, -1),
        np.where(a > 0, np.where(b > 0, c, b), np.clip(b, -c, c)),
        where(b <= a, b, 2) + maximum(a, c),
        np.clip(a, 0, None) + np.clip(b, None, 0.5),
        np.clip(a, a_min=FLOOR, a_max=c) * np.clip(b, 0, a_max=1),
        clip(a),
        np.minimum(a, 1) + np.minimum(0.5, b) + np.minimum(a, b),
        np.maximum(np.minimum(a, b), c) + np.maximum(0, a),
        np.fmin(a, b) + np.fmax(a, c),
        np.sign(a - c) * b,
        np.heaviside(a, 0.5) + np.heaviside(b, a),
        np.abs(a) + abs(b) + np.absolute(a - b) + np.fabs(b),
        (a > b) * a + (a <= c) * b,
        np.logical_and(a > 0, b > 0) * c + np.logical_or(a > 0, b > 0) * b,
        np.logical_not(a > b) * a + np.logical_xor(a > 0, b > 0) * b,
        ((a > 0) & (b > 0)) * c + ((a > 0) | (b > 0)) * a + (~(a > 0)) * b,
        np.isnan(a) * 1.0 + np.isfinite(b),
        np.copysign(np.sqrt(np.abs(a)), a),
        special.erf(a) + special.erfc(b) + special.gamma(c + 0.5) + special.gammaln(c + 1.0),
    )


def test_compiled_they_give_what_numpy_gives() -> None:
    pytest.importorskip('numba')
    from obs_ros.integration.compiled import CompiledKernels

    count = len(output(0.0, (1.0, 2.0), (), (1.0,)))
    model = Model(
        name='choices',
        states=(Variable('a', lower=-2, upper=2), Variable('b', lower=-2, upper=2)),
        outputs=tuple(Variable(f'y{i}') for i in range(count)),
        parameters=(Variable('c', lower=0, upper=2),),
        dynamics=lambda t, x, u, p: (0.0, 0.0),
        output=output,
    )
    pairs = np.array([*itertools.product(FLOATS, FLOATS)]).T
    x0 = np.hstack([pairs, np.random.default_rng(0).uniform(-2.0, 2.0, (2, 64))])
    x0, p = np.hstack([x0, x0]), np.repeat([[0.7, math.nan]], x0.shape[1], axis=1)
    grid = Grid.of(model, Record([0.0, 1.0], None, np.zeros((2, count))), np.ones(count))
    _, found = CompiledKernels(model).trajectories(grid, x0, p)
    _, expected = NumpyKernels(model).trajectories(grid, x0, p)
    for i in range(count):
        np.testing.assert_allclose(found[:, i], expected[:, i], rtol=1e-9, err_msg=f'y{i}')


LEVELS = np.linspace(0.0, 1.0, 100)  # of less than 65 entries the table is recorded


def test_what_compiles_to_slow_code_is_named(caplog: Any) -> None:
    pytest.importorskip('numba')
    from obs_ros.integration.kernel_modules import load_module

    slow = replace(BLOW_UP, dynamics=lambda t, x, u, p: (np.interp(x[0], LEVELS, LEVELS),))
    with caplog.at_level(logging.WARNING, 'obs_ros'):
        load_module(slow)
        load_module(slow)
    (message,) = caplog.messages
    assert message.startswith("model 'blow_up': use np.where, np.clip and arithmetic in place of")
    assert 'np.interp' in message


def test_what_still_does_not_compile_is_named(caplog: Any) -> None:
    pytest.importorskip('numba')
    dynamics = lambda t, x, u, p: (expit(x[0]),)  # noqa: E731
    odd = replace(BLOW_UP, name='odd', dynamics=dynamics)
    with caplog.at_level(logging.WARNING, 'obs_ros'):
        assert kernels_for(odd).name == 'numpy'
    message = caplog.messages[-1]
    assert message.startswith("model 'odd' cannot be compiled: Untyped global name 'expit'")
    assert re.search(r'\(test_selects.py:\d+: `dynamics = lambda t, x, u, p: ', message)
    assert message.endswith('; NumPy is used, which is slower')
