"""Tests of obs_ros.observers.papers.design.plants."""

import numpy as np
import pytest

from obs_ros.models.suspension import KT, MUS, SUSPENSION
from obs_ros.observers.papers.design.plants import suspension


def rates(x: np.ndarray, kt: float) -> np.ndarray:
    """Those of the model on a flat road without current."""
    names = [v.name for v in SUSPENSION.parameters]
    p = tuple(kt if name == 'kt' else v.nominal for name, v in zip(names, SUSPENSION.parameters))
    u = tuple(0.0 for _ in SUSPENSION.inputs)
    return np.array(SUSPENSION.dynamics(0.0, tuple(x), u, p))


def test_the_tyre_s_share_is_what_phi_has_of_it() -> None:
    plant, all_of_kt = suspension(share=0.2), suspension(share=None)
    assert plant.gamma == pytest.approx(0.2 * KT / MUS) and all_of_kt.gamma == KT / MUS
    np.testing.assert_allclose(plant.A, all_of_kt.A - KT / MUS * all_of_kt.B @ all_of_kt.E)
    assert suspension(wheel_speed=True).C.shape == (4, 4) and plant.C.shape == (3, 4)


def test_a_softer_tyre_changes_the_model_as_b_phi_does() -> None:
    """phi = kt (zr - zus) / mus, so that a change of kt acts along B E."""
    plant, x = suspension(), np.array([0.01, 0.1, 0.02, -0.2])
    change = rates(x, 0.9 * KT) - rates(x, KT)
    np.testing.assert_allclose(change, 0.1 * KT / MUS * (plant.B @ plant.E) @ x, rtol=1e-9)
