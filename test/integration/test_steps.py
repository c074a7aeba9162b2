"""Tests of obs_ros.integration.steps."""

import numpy as np
import pytest

from obs_ros.core.model import Method, get_args
from obs_ros.integration.steps import STEPS, axpy, euler, rk4


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


def test_arrays_go_entry_by_entry() -> None:
    a, b = axpy((np.array([1.0, 2.0]), 3.0), 2.0, (10.0, np.array([1.0, 2.0])))
    assert a.tolist() == [21.0, 22.0] and b.tolist() == [5.0, 7.0]
