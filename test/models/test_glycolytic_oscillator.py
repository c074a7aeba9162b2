"""Tests of obs_ros.models.glycolytic_oscillator, against Porter & Passino 1995, eq. 17."""

import numpy as np
import pytest

from obs_ros.core.model import inside
from obs_ros.models.glycolytic_oscillator import GLYCOLYTIC_OSCILLATOR as PLANT

NOMINAL = tuple(inside(v) for v in PLANT.parameters)


def test_rates_are_those_of_the_paper_and_of_its_mismatched_plant() -> None:
    x1, x2, u = 1.5, 1.2, 0.9
    assert PLANT.dynamics(0.0, (x1, x2), (u,), NOMINAL) == pytest.approx((-1.26, 0.96), rel=1e-14)
    assert PLANT.dynamics(0.0, (x1, x2), (u,), (0.8, 1.0)) == pytest.approx(
        (-0.8 * 2.16 + 0.9, 0.96), rel=1e-14
    )
    assert PLANT.output(0.0, (x1, x2), (u,), NOMINAL) == (x1,)


def test_a_constant_feed_is_balanced_at_its_inverse_and_oscillates_below_one() -> None:
    def jacobian(u: float) -> np.ndarray:
        x, step = np.array([1.0 / u, u]), 1e-6
        columns = [
            np.subtract(*(PLANT.dynamics(0.0, x + sign * e, (u,), NOMINAL) for sign in (1, -1)))
            for e in step * np.eye(2)
        ]
        return np.array(columns).T / (2.0 * step)

    assert PLANT.dynamics(0.0, (1.25, 0.8), (0.8,), NOMINAL) == pytest.approx((0, 0), abs=1e-15)
    # At x = (1/u, u): trace 1 - u^2, determinant u^2, so that u = 1 is a Hopf bifurcation.
    for u in (0.9, 1.1):
        np.testing.assert_allclose(np.trace(jacobian(u)), 1.0 - u * u, atol=1e-8)
        np.testing.assert_allclose(np.linalg.det(jacobian(u)), u * u, atol=1e-8)


def test_without_product_none_is_made() -> None:
    assert PLANT.dynamics(0.0, (1.7, 0.0), (0.4,), NOMINAL) == (0.4, 0.0)
