"""Tests of obs_ros.models.suspension against Alvarado-Méndez et al. 2024."""

import numpy as np
import pytest

from obs_ros.models import suspension as plant
from obs_ros.models.suspension import SUSPENSION

X, ROAD = (0.03, 0.2, 0.01, -0.4), 0.04


def rates(x: tuple[float, ...] = X, zr: float = ROAD, amp: float = 2.0, kt: float = 2.6e5,
          eta: float = 0.0) -> tuple[float, ...]:  # fmt: skip
    return tuple(float(v) for v in SUSPENSION.dynamics(0.0, x, (zr, amp), (kt, eta)))


def test_the_linear_part_is_the_papers_matrix() -> None:
    """Eq. 37: A, and Phi = kt (zr - x3) / mus, without current."""
    stiff, damp = plant.B2 + plant.KS, plant.B1
    a = np.array(
        [
            [0.0, 1.0, 0.0, 0.0],
            [-stiff / 470.0, -damp / 470.0, stiff / 470.0, damp / 470.0],
            [0.0, 0.0, 0.0, 1.0],
            [stiff / 110.0, damp / 110.0, -stiff / 110.0, -damp / 110.0],
        ]
    )
    expected = a @ np.array(X) + np.array([0.0, 0.0, 0.0, 2.6e5 * (ROAD - 0.01) / 110.0])
    np.testing.assert_allclose(rates(amp=0.0), expected, rtol=1e-12)


def test_the_damper_pulls_both_masses_together_by_the_same_force() -> None:
    off, on, disturbed = rates(amp=0.0), rates(amp=2.0), rates(eta=300.0)
    force = 2.0 * 600.95 * np.tanh(37.8 * 0.6 + 22.15 * 0.02)
    assert [on[1] - off[1], on[3] - off[3]] == pytest.approx([-force / 470.0, force / 110.0])
    assert [disturbed[1] - on[1], disturbed[3] - on[3]] == pytest.approx([-300 / 470, 300 / 110])


def test_it_rests_on_the_road_wherever_that_is() -> None:
    assert rates((0.07, 0.0, 0.07, 0.0), 0.07) == pytest.approx((0.0, 0.0, 0.0, 0.0), abs=1e-12)


def test_the_operating_range_of_the_damper_is_that_of_the_specification() -> None:
    """The disturbance of 300 N is 15 % of it."""
    assert round(300.0 / 2007.0, 2) == 0.15
    assert SUSPENSION.variable('eta').upper >= 300.0
    assert SUSPENSION.variable('eta').walk == np.inf  # new in every window
    assert SUSPENSION.variable('kt').walk is None
    kt = SUSPENSION.variable('kt')
    assert (kt.lower, kt.upper) == pytest.approx((26000.0, 780000.0))
