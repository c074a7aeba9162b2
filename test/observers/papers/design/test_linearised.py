"""Tests of obs_ros.observers.papers.design.linearised, beside the suspension's own matrices."""

from dataclasses import replace

import numpy as np
import pytest

from obs_ros.models import load_model
from obs_ros.models.suspension import A1, A2, FC, KT, MS, MUS
from obs_ros.observers.papers.adaptive_gains import stored_gains
from obs_ros.observers.papers.design.linearised import linearised, stable_share
from obs_ros.observers.papers.design.plants import suspension

SUSPENSION = load_model('suspension')


def test_the_suspension_comes_out_as_written_by_hand() -> None:
    """But for the hysteresis at rest, 2 A of current, which the one by hand leaves out."""
    found, known = linearised(SUSPENSION, ['kt'], disturbances=['eta']), suspension()
    rho = 2.0 * FC * np.array([A2, A1, -A2, -A1])
    hysteresis = np.outer([0.0, -1.0 / MS, 0.0, 1.0 / MUS], rho)
    np.testing.assert_allclose(found.A, known.A + hysteresis, rtol=1e-6, atol=1e-6)
    np.testing.assert_allclose(found.C, known.C, atol=1e-9)
    direction = found.B[:, 0] / np.linalg.norm(found.B)
    np.testing.assert_allclose(direction, [0.0, 0.0, 0.0, 1.0], atol=1e-9)
    steepest = found.gamma * np.linalg.norm(found.B) * found.E
    np.testing.assert_allclose(steepest, [[0.0, 0.0, 0.2 * KT / MUS, 0.0]], rtol=1e-6, atol=1e-3)
    np.testing.assert_allclose(found.N / 2000.0, known.N, rtol=1e-6)  # half the range of eta, N


def test_without_disturbances_every_state_is_pushed() -> None:
    plant = linearised(SUSPENSION, ['kt'])
    np.testing.assert_allclose(plant.N, np.diag([0.5, 5.0, 0.5, 5.0]))


def test_several_parameters_share_directions() -> None:
    """dP1 and k1 both act where the utility valve does, on Tu and X1; dP2 on Tp."""
    plant = linearised(load_model('heat_exchanger_reduced'), ['dP1', 'dP2', 'k1'])
    assert plant.B.shape == (4, 3)
    assert np.linalg.matrix_rank(plant.B) == 3
    assert np.abs(plant.B[3]).max() < 1e-9 * np.abs(plant.B).max()  # none acts on X2


def test_a_parameter_on_which_nothing_depends_is_refused() -> None:
    with pytest.raises(ValueError, match="no parameter 'kz': did you mean 'kt'"):
        linearised(SUSPENSION, ['kz'])
    still = replace(
        SUSPENSION, name='still', dynamics=lambda t, x, u, p: (x[1], -x[0], x[3], -x[2])
    )
    with pytest.raises(ValueError, match='leave kt out: no rate of still depends on it'):
        linearised(still, ['kt'])


def test_gains_are_tried_all_over_the_box() -> None:
    L = stored_gains(SUSPENSION, 'designed').L
    assert stable_share(SUSPENSION, L) == (200, 200)
    assert stable_share(SUSPENSION, -100.0 * L)[0] == 0
