"""Tests of obs_ros.models.linear_second_order, against Porter & Passino 1995, eqs. 12-15."""

import pytest

from obs_ros.core.model import inside
from obs_ros.models.linear_second_order import LINEAR_SECOND_ORDER as PLANT

NOMINAL = tuple(inside(v) for v in PLANT.parameters)


def test_one_euler_step_is_the_difference_equation_of_the_paper() -> None:
    x1, x2, u, T = 1.3, -0.4, 0.7, 0.01
    dx1, dx2 = PLANT.dynamics(0.0, (x1, x2), (u,), NOMINAL)
    assert x1 + T * dx1 == pytest.approx(0.9775 * x1 - 0.045 * x2, rel=1e-14)  # eq. 14
    assert x2 + T * dx2 == pytest.approx(0.945 * x2 + 0.01 * u, rel=1e-14)  # eq. 15


def test_a_held_input_ends_in_its_equilibrium() -> None:
    x2 = 0.999 / 5.5
    rates = PLANT.dynamics(0.0, (-4.5 / 2.25 * x2, x2), (0.999,), NOMINAL)
    assert rates == pytest.approx((0.0, 0.0), abs=1e-15)
    assert PLANT.output(0.0, (3.0, 4.0), (0.0,), NOMINAL) == (3.0,)
