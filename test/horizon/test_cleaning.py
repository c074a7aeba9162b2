"""Tests of obs_ros.horizon.cleaning."""

from dataclasses import replace

import numpy as np
import pytest
from horizon.test_disturbance import SIGMA as PUSHED
from horizon.test_disturbance import pushed
from plants import LAG, lag_outputs, square_wave

from obs_ros import Record
from obs_ros.core.deadline import Deadline
from obs_ros.core.rng import random_generator
from obs_ros.horizon.cleaning import cleaned, in_own_scale, refitted
from obs_ros.horizon.settings import EstimationSettings
from obs_ros.horizon.solver import Solver
from obs_ros.inference.window_state import WindowState
from obs_ros.optimization.acceptance import Acceptance
from obs_ros.optimization.result import Found

T = 0.1 * np.arange(300)
SIGMA = 0.05
SOLVER = Solver.of(LAG)


def fitted(*, spike: float, noise_known: bool) -> tuple[WindowState, Found]:
    u = square_wave(T)
    y = lag_outputs(T, u, 0.5, np.tile([1.2, 3.0], (T.size - 1, 1)))
    y += SIGMA * np.random.default_rng(3).standard_normal(y.shape)
    y[140] += spike * SIGMA
    window = SOLVER.pose(Record(T, u, y), np.array([SIGMA]), noise_known=noise_known)
    return SOLVER.fit(window, window.posterior, random_generator(1), Deadline(), None)


@pytest.mark.parametrize('noise_known', [True, False])
def test_an_outlier_is_left_out_and_what_is_left_is_like_noise(noise_known: bool) -> None:
    window, found = fitted(spike=20.0, noise_known=noise_known)
    clean, without = cleaned(window, replace(found, accepted=None), Deadline())
    (outlier,) = clean.outliers
    assert outlier.time == pytest.approx(14.0)
    assert outlier.size == pytest.approx(20.0, abs=3.0)
    freedom = T.size - 1 - 3
    assert without.cost == pytest.approx(freedom, abs=4.0 * np.sqrt(2.0 * freedom))
    assert without.accepted is (Acceptance.LIKE_NOISE if noise_known else None)
    if not noise_known:
        assert clean.objective.grid.scale[0] == pytest.approx(SIGMA, rel=0.15)


@pytest.mark.parametrize(('jumps_follow', 'left'), [(True, 0), (False, 3)])
def test_a_jump_may_stand_for_outliers_only_where_jumps_are_sought(
    jumps_follow: bool, left: int
) -> None:
    """Of a plant that is pushed about nearly every jump explains something."""
    record, _ = pushed(400, seed=0)
    y, places = record.y.copy(), [60, 180, 260]
    y[places, 0] += 3.0 * PUSHED * np.array([30.0, -25.0, 12.0])
    window = SOLVER.pose(record.with_outputs(y), noise_known=False)
    window, found = SOLVER.fit(window, window.posterior, random_generator(1), Deadline(), None)
    clean, _ = cleaned(window, found, Deadline(), jumps_follow=jumps_follow)
    times = [outlier.time for outlier in clean.outliers]
    assert times == pytest.approx(record.t[places].tolist()[:left])


def test_without_outliers_nothing_changes() -> None:
    window, found = fitted(spike=0.0, noise_known=True)
    before = window.objective.evaluations
    assert cleaned(window, found, Deadline()) == (window, found)
    assert window.objective.evaluations == before  # the rollout of the fit is at hand


def test_a_first_sample_that_alone_tells_the_initial_state_is_no_outlier() -> None:
    fast = replace(LAG, max_step=0.01)
    solver = Solver.of(fast, EstimationSettings(backend='numpy', bounds={'tau': (0.04, 0.1)}))
    u = square_wave(T)
    y = lag_outputs(T, u, 0.5, np.tile([1.2, 0.05], (T.size - 1, 1)))
    y += SIGMA * np.random.default_rng(3).standard_normal(y.shape)
    y[0] += 10.0 * SIGMA
    window = solver.pose(Record(T, u, y), np.array([SIGMA]), noise_known=True)
    window, found = solver.fit(window, window.posterior, random_generator(1), Deadline(), None)
    expected = solver.unknowns.point({'x': 0.5, 'k': 1.2, 'tau': 0.05})
    for x in (found.z[0], expected[0]):
        start = replace(found, z=np.append(x, found.z[1:]))
        clean, again = cleaned(window, start, Deadline())
        assert not clean.outliers and again is start


def test_a_window_in_its_own_scale_leaves_unit_noise() -> None:
    window, found = fitted(spike=0.0, noise_known=False)
    window = window.rescaled(np.array([5.0]))
    own, again = in_own_scale(window, found, Deadline())
    assert own.objective.grid.scale[0] == pytest.approx(SIGMA, rel=0.15)
    assert again.cost == pytest.approx(T.size - 3, rel=0.02)


def test_a_window_without_some_samples_is_fitted_again() -> None:
    window, found = fitted(spike=200.0, noise_known=True)
    gone = np.zeros((T.size, 1), dtype=bool)
    gone[140] = True
    _, again = refitted(window.without(gone), found, Deadline())
    _, calm = fitted(spike=0.0, noise_known=True)
    np.testing.assert_allclose(again.z, calm.z, atol=0.01)
