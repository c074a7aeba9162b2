"""Tests of obs_ros.models.jet_engine, against Gremling & Passino 2000, eqs. 21-23."""

import numpy as np
import pytest

from obs_ros.core.model import inside
from obs_ros.models.jet_engine import JET_ENGINE as PLANT

C = tuple(inside(v) for v in PLANT.parameters)


def test_rates_by_hand() -> None:
    """Eq. 21 at Phi = 0.8, Psi = 0.5, R = 0.1, Phi_T = 0.3, state order (Psi, R, Phi)."""
    rates = PLANT.dynamics(0.0, (0.5, 0.1, 0.8), (0.3,), C)
    assert rates == pytest.approx((0.24115, 0.182, -0.5 + 0.5 + 1 + 1.2 - 0.256 - 0.24), rel=1e-12)
    assert PLANT.output(0.0, (0.5, 0.1, 0.8), (0.3,), C) == (0.5,)


def test_the_peak_of_the_characteristic_is_an_equilibrium() -> None:
    """At Phi = 1 without stall the pressure rise is Psi_C0 + 2, the most there is."""
    assert PLANT.dynamics(0.0, (2.5, 0.0, 1.0), (1.0,), C) == (0.0, 0.0, 0.0)
    along = [PLANT.dynamics(0.0, (0.0, 0.0, phi), (1.0,), C)[2] for phi in (0.9, 1.0, 1.1)]
    assert max(along) == along[1] == 2.5


@pytest.mark.parametrize(('phi', 'rate'), [(1.2, -3.08), (0.8, 2.52)])
def test_stall_grows_below_the_peak_and_dies_above(phi: float, rate: float) -> None:
    """At R = 0 its rate is sigma (1 - Phi^2) R."""
    small = 1e-9
    assert PLANT.dynamics(0.0, (2.5, small, phi), (1.0,), C)[1] / small == pytest.approx(rate)


def test_stall_never_leaves_its_bounds() -> None:
    phi = np.linspace(-2.5, 2.5, 101)
    assert not np.any(PLANT.dynamics(0.0, (2.0, 0.0, phi), (1.0,), C)[1])
    assert np.all(PLANT.dynamics(0.0, (2.0, 1.0, phi), (1.0,), C)[1] <= 0.0)
    assert np.all(PLANT.dynamics(0.0, (2.0, 1.2, phi), (1.0,), C)[1] < 0.0)
