"""Tests of obs_ros.integration.steps."""

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from obs_ros.core.model import Method, get_args
from obs_ros.integration.steps import STEPS, axpy, euler, rk4, rosenbrock


def test_there_is_a_step_for_every_method() -> None:
    assert set(STEPS) == set(get_args(Method))


def test_euler_uses_the_state_and_input_at_the_begin() -> None:
    f = lambda t, x, u, p: (t + x[0] + u[0] * p[0], 1.0)  # noqa: E731
    assert euler(f, 2.0, 0.5, (3.0, 4.0), (5.0,), (99.0,), (99.0,), (10.0,)) == (30.5, 4.5)


def test_rk4_integrates_cubics_in_time_exactly() -> None:
    x = rk4(lambda t, x, u, p: (4.0 * t**3,), 1.0, 2.0, (1.0,), (), (), (), ())
    assert x[0] == pytest.approx(81.0, rel=1e-14)


def test_rk4_weights_inputs_by_simpson() -> None:
    x = rk4(lambda t, x, u, p: (u[0],), 0.0, 6.0, (0.0,), (1.0,), (10.0,), (100.0,), ())
    assert x[0] == pytest.approx(1.0 + 40.0 + 100.0, rel=1e-15)


def test_rk4_is_the_taylor_polynomial_of_the_exponential() -> None:
    x = rk4(lambda t, x, u, p: (p[0] * x[0],), 0.0, 0.1, (1.0,), (), (), (), (-2.0,))
    assert x[0] == pytest.approx(1 - 0.2 + 0.02 - 0.2**3 / 6 + 0.2**4 / 24, rel=1e-15)


def driven(t: Any, x: Any, u: Any, p: Any) -> Any:
    """Time, an input and both states enter nonlinearly."""
    a, b = x
    return -p[0] * (a - np.cos(t)) + u[0] * b, a * a * u[0] - b * np.sin(3.0 * t) ** 2


@pytest.mark.parametrize('slope', [0.0, 0.7])
def test_rosenbrock_has_order_three_in_states_time_and_straight_inputs(slope: float) -> None:
    def u(t: float) -> tuple[float]:
        return (0.5 + slope * t,)

    truth = solve_ivp(
        lambda t, x: driven(t, x, u(t), (2.0,)), (0.0, 1.0), [1.0, 0.5], 'Radau', rtol=1e-12,
        atol=1e-13,
    ).y[:, -1]  # fmt: skip
    errors = []
    for steps in (32, 64, 128, 256):
        h, x = 1.0 / steps, (1.0, 0.5)
        for k in range(steps):
            inputs = (u((k + part) * h) for part in (0.0, 0.5, 1.0))
            x = rosenbrock(driven, k * h, h, x, *inputs, (2.0,))
        errors.append(np.abs(np.array(x) - truth).max())
    for coarse, fine in pairwise(errors):
        assert coarse / fine == pytest.approx(8.0, rel=0.1)


def test_rosenbrock_damps_fast_modes_whatever_the_step() -> None:
    x = rosenbrock(lambda t, x, u, p: (p[0] * x[0],), 0.0, 1.0, (1.0,), (), (), (), (-1e6,))
    assert abs(x[0]) < 1e-5


def test_rosenbrock_follows_a_ramp_that_a_fast_mode_is_dragged_along() -> None:
    """The slow solution of x' = lambda (x - u), u a straight line, is u + slope / lambda."""
    x = rosenbrock(
        lambda t, x, u, p: (p[0] * (x[0] - u[0]),), 0.0, 0.1,
        (2.0 + 5.0 / -1e5,), (2.0,), (2.25,), (2.5,), (-1e5,),
    )  # fmt: skip
    assert x[0] == pytest.approx(2.5 + 5.0 / -1e5, abs=1e-12)


def test_rosenbrock_is_the_approximation_of_the_exponential() -> None:
    """R(z) of Sandu et al. 1997 agrees with exp(z) to order 3."""
    for z in (1e-2, -1e-2):
        x = rosenbrock(lambda t, x, u, p: (p[0] * x[0],), 0.0, 1.0, (1.0,), (), (), (), (z,))
        assert x[0] == pytest.approx(np.exp(z), abs=0.2 * z**4)


def test_arrays_go_entry_by_entry() -> None:
    a, b = axpy((np.array([1.0, 2.0]), 3.0), 2.0, (10.0, np.array([1.0, 2.0])))
    assert a.tolist() == [21.0, 22.0] and b.tolist() == [5.0, 7.0]
