"""Tests of obs_ros.inference.outliers."""

from dataclasses import replace

import numpy as np
import pytest

from obs_ros import Record
from obs_ros.horizon.solver import Solver
from obs_ros.inference.outliers import (
    OUTLIERS,
    first_far,
    left_out,
    outliers_in,
    repeated,
    spread,
    suspects,
)
from obs_ros.inference.window_state import Outlier, WindowState
from obs_ros.models.three_tank import THREE_TANK


def noise(size: int, seed: int = 0, outputs: int = 1) -> np.ndarray:
    return np.random.default_rng([seed, 71]).standard_normal((size, outputs))


def found_in(residuals: np.ndarray, *, noise_known: bool = True) -> np.ndarray:
    """Suspects among residuals of values that never repeat."""
    return suspects(
        residuals, noise(len(residuals), 9, residuals.shape[1]), noise_known=noise_known
    )


@pytest.mark.parametrize('noise_known', [True, False])
def test_of_gaussian_noise_next_to_nothing_is_an_outlier(noise_known: bool) -> None:
    found = sum(
        int(found_in(noise(200, seed, 2), noise_known=noise_known).sum()) for seed in range(500)
    )
    assert found <= 4  # of 200 000 samples: far less than one in 2000


@pytest.mark.parametrize('unit', [1.0, 0.4])
def test_single_samples_far_out_are_suspect(unit: float) -> None:
    residuals = unit * noise(200)
    residuals[[0, 50, 51, 120], 0] = unit * np.array([9.0, -12.0, 11.0, -400.0])
    residuals[10] = np.nan
    found = found_in(residuals, noise_known=unit == 1.0)
    assert np.flatnonzero(found[:, 0]).tolist() == [0, 50, 51, 120]


@pytest.mark.parametrize(
    'pattern',
    [
        [10.0, 4.0, 1.6],  # the decay after a jump of a fast parameter
        [4.0, 10.0],
        [3.0, 6.0, 9.0, 6.0, 3.0],  # a model's smooth error
    ],
)
def test_samples_with_others_far_out_beside_them_are_not(pattern: list[float]) -> None:
    residuals = noise(200)
    residuals[80 : 80 + len(pattern), 0] = pattern
    assert not found_in(residuals).any()


@pytest.mark.parametrize(
    'pattern',
    [
        [10.0, 10.0, 10.0],
        [-12.0, -13.0, -11.0, -12.0, -13.0, -12.0],  # an offset that comes and goes
        [40.0, -9.0, 1.0, -60.0, 25.0, 70.0, -8.0],  # a loose contact, with one that looks sound
        [2.0, 6.0, 10.0, 14.0, 18.0],  # comes slowly, goes at once
    ],
)
def test_bursts_are(pattern: list[float]) -> None:
    residuals = noise(200)
    residuals[80 : 80 + len(pattern), 0] = pattern
    far = np.flatnonzero(found_in(residuals)[:, 0]) - 80
    first = 1 if pattern[0] == 2.0 else 0
    assert far.tolist() == list(range(first, len(pattern)))


def test_values_that_repeat_are_one_value() -> None:
    residuals, y = noise(200), noise(200, 9)
    residuals[80:83, 0] = [4.1, 3.4, 2.8]  # a burst none of which is far out alone
    assert not suspects(residuals, y, noise_known=True).any()
    y[80:83] = 0.0
    assert np.flatnonzero(suspects(residuals, y, noise_known=True)).tolist() == [80, 81, 82]
    assert repeated(y[:, 0]) == [(80, 83)]
    assert repeated(np.round(3.0 * y[:, 0])) == []  # a coarse sensor


def test_many_are_another_noise_and_one_is_always_allowed() -> None:
    residuals = noise(200)
    residuals[3:195:4, 0] = 10.0  # 24 %
    assert not found_in(residuals).any()
    few = noise(20)
    few[7] = 8.0
    assert found_in(few).sum() == 1


def test_a_noise_that_was_given_too_small_makes_no_outliers() -> None:
    assert not found_in(4.0 * noise(2000)).any()


def test_the_spread_is_that_of_most_samples() -> None:
    residuals = 0.3 * noise(4000, outputs=2)
    residuals[:100] = 30.0
    residuals[:, 1] = np.nan
    found = spread(residuals, noise_known=False)
    assert found[0] == pytest.approx(0.3, rel=0.06) and found[1] == np.inf
    assert spread(residuals, noise_known=True)[0] == 1.0


def test_what_is_left_out_counts_as_not_measured() -> None:
    t = np.arange(30.0)
    record = Record(t, np.full((30, 2), 20.0), 30.0 + noise(30, 3, 2), stamp=29 * 10**9)
    window = Solver.of(THREE_TANK).pose(record, np.ones(2), noise_known=True)
    y = window.record.y
    found = np.zeros(y.shape, dtype=bool)
    found[-1] = True, True
    found[7, 0] = True
    residuals = np.where(found, 8.0, 0.5)
    left = left_out(window, found, residuals)
    assert np.isnan(left.record.y[found]).all()
    np.testing.assert_array_equal(left.record.y[~found], y[~found])
    assert left.objective.grid.measured_values(len(y)) == y.size - 3
    assert not left.objective.grid.measured[-1] and left.objective.grid.measured[7]
    assert left.record.stamp == window.record.stamp - 10**9  # that of the newest left
    assert left.outliers[0] == Outlier(window.record.t[7], 0, 8.0)
    assert len(left.outliers) == 3
    assert not window.outliers


def posed() -> WindowState:
    t = np.arange(30.0)
    record = Record(t, np.full((30, 2), 20.0), 30.0 + noise(30, 3, 2))
    return Solver.of(THREE_TANK).pose(record, np.ones(2), noise_known=True)


def test_more_than_a_few_in_a_row_are_a_burst() -> None:
    found = np.zeros((30, 2), dtype=bool)
    found[5 : 5 + OUTLIERS.few, 0] = True
    found[20 : 21 + OUTLIERS.few, 0] = True
    left = left_out(posed(), found, np.full((30, 2), 9.0))
    bursts = [outlier.burst for outlier in left.outliers]
    assert bursts == [None] * OUTLIERS.few + [20.0] * (OUTLIERS.few + 1)


def test_the_first_of_a_run_of_innovations_is_one_whatever_follows() -> None:
    innovations = 0.5 * noise(30, 3, 2)
    innovations[7:10, 0] = 20.0, -9.0, 4.0  # the filter's answer
    innovations[20, 0] = -8.0
    innovations[12:14, 1] = np.nan, 9.0
    window = posed()
    assert not outliers_in(window, innovations, noise_known=True)[7:10, 0].any()
    found = first_far(window, innovations, noise_known=True)
    assert np.argwhere(found).tolist() == [[7, 0], [13, 1], [20, 0]]
    assert (first_far(window, 0.1 * innovations, noise_known=False) == found).all()
    assert not first_far(window, 0.1 * innovations, noise_known=True).any()
    many = np.where(np.arange(30) % 3 == 0, 30.0, 0.5)[:, None]
    assert not first_far(window, np.repeat(many, 2, axis=1), noise_known=True).any()


def test_a_loss_of_squares_has_no_outliers() -> None:
    residuals = noise(30, 3, 2)
    residuals[7, 0] = 50.0
    window = posed()
    assert outliers_in(window, residuals, noise_known=True).sum() == 1
    plain = replace(window, robust=False)
    assert not outliers_in(plain, residuals, noise_known=True).any()
    assert first_far(window, residuals, noise_known=True).sum() == 1
    assert not first_far(plain, residuals, noise_known=True).any()
