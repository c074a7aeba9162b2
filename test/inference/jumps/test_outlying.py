"""Tests of obs_ros.inference.jumps.outlying."""

from dataclasses import replace

import numpy as np
import pytest
from jump_windows import SIGMA, record, still, with_a_drift_jump

from obs_ros import Record
from obs_ros.core.deadline import Deadline
from obs_ros.inference.jumps.outlying import Cleaned, beside, without_outliers
from obs_ros.inference.prior import Prior
from obs_ros.inference.window_state import WindowState

BURST = dict.fromkeys(range(30, 45), 20.0)  # an offset for 1.5 s


def spiked(sizes: dict[int, float], jump: float = 0.0) -> Record:
    """The window of the integrator, some samples off by so many standard deviations."""
    window = record(jump)
    y = window.y.copy()
    for node, size in sizes.items():
        y[node] += size * SIGMA
    return Record(window.t, window.u, y)


def posed(window: Record, *, noise_known: bool = True) -> WindowState:
    objective = still(window).problem.objective
    return WindowState(window, objective, Prior.box(objective.unknowns), noise_known=noise_known)


def cleaned(window: Record, *, noise_known: bool = True) -> Cleaned | None:
    return without_outliers(
        posed(window, noise_known=noise_known), [still(window).point], Deadline()
    )


@pytest.mark.parametrize('noise_known', [True, False])
@pytest.mark.parametrize('sizes', [{50: 10.0}, {20: -8.0, 70: 9.0}, {100: 12.0}, {40: 1e3}, BURST])
def test_single_samples_are_left_out_and_the_rest_fitted_without_them(
    sizes: dict[int, float], noise_known: bool
) -> None:
    found = cleaned(spiked(sizes), noise_known=noise_known)
    assert found is not None
    nodes = [round(outlier.time / 0.1) for outlier in found.window.outliers]
    assert nodes == sorted(sizes)
    kept = record()
    y = kept.y.copy()
    y[nodes] = np.nan
    alone = still(Record(kept.t, kept.u, y))
    np.testing.assert_allclose(found.z, alone.point, atol=2e-3)
    for outlier, node in zip(found.window.outliers, nodes, strict=True):
        assert outlier.size == pytest.approx(abs(sizes[node]), abs=2.5, rel=0.4)


def test_a_window_without_any_is_left_as_it_is() -> None:
    assert cleaned(record()) is None


def test_a_loss_of_squares_leaves_none_out() -> None:
    window = spiked({50: 10.0})
    start = [still(window).point]
    assert without_outliers(posed(window), start, Deadline()) is not None
    assert without_outliers(replace(posed(window), robust=False), start, Deadline()) is None


def test_a_jump_stands_for_its_own_first_samples() -> None:
    assert cleaned(record(0.6)) is None


def test_evidence_says_which_hypothesis_has_outliers_beside_it() -> None:
    window = spiked({80: 12.0}, jump=0.6)
    tried = [still(window), with_a_drift_jump(window)]
    found = beside(posed(window), tried)
    assert found is not None
    far, residuals = found
    assert np.argwhere(far).tolist() == [[80, 0]] and abs(residuals[80, 0]) > 9.0
    calm = record(0.6)
    assert beside(posed(calm), [still(calm), with_a_drift_jump(calm)]) is None
