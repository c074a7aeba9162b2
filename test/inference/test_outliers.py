"""Tests of obs_ros.inference.outliers."""

import numpy as np
import pytest

from obs_ros import Record
from obs_ros.horizon.solver import Solver
from obs_ros.inference.outliers import (
    OUTLIERS,
    OutlierCount,
    left_out,
    spread,
    suspects,
    words,
)
from obs_ros.inference.window_state import Outlier
from obs_ros.models.three_tank import THREE_TANK


def noise(size: int, seed: int = 0, outputs: int = 1) -> np.ndarray:
    return np.random.default_rng([seed, 71]).standard_normal((size, outputs))


@pytest.mark.parametrize('noise_known', [True, False])
def test_of_gaussian_noise_next_to_nothing_is_an_outlier(noise_known: bool) -> None:
    found = sum(
        int(suspects(noise(200, seed, 2), noise_known=noise_known).sum()) for seed in range(500)
    )
    assert found <= 4  # of 200 000 samples: far less than one in 2000


@pytest.mark.parametrize('unit', [1.0, 0.4])
def test_single_samples_far_out_are_suspect(unit: float) -> None:
    residuals = unit * noise(200)
    residuals[[0, 50, 51, 120], 0] = unit * np.array([9.0, -12.0, 11.0, -400.0])
    residuals[10] = np.nan
    found = suspects(residuals, noise_known=unit == 1.0)
    assert np.flatnonzero(found[:, 0]).tolist() == [0, 50, 51, 120]


@pytest.mark.parametrize(
    'pattern',
    [
        [10.0, 10.0, 10.0],  # a burst
        [10.0, 4.0, 1.6],  # the decay after a jump of a fast parameter
        [4.0, 10.0],
        [3.0, 6.0, 9.0, 6.0, 3.0],  # a model's smooth error
    ],
)
def test_samples_with_others_far_out_beside_them_are_not(pattern: list[float]) -> None:
    residuals = noise(200)
    residuals[80 : 80 + len(pattern), 0] = pattern
    assert not suspects(residuals, noise_known=True).any()


def test_many_are_another_noise_and_one_is_always_allowed() -> None:
    residuals = noise(200)
    residuals[5:195:20, 0] = 10.0  # 5 %
    assert not suspects(residuals, noise_known=True).any()
    few = noise(20)
    few[7] = 8.0
    assert suspects(few, noise_known=True).sum() == 1


def test_a_noise_that_was_given_too_small_makes_no_outliers() -> None:
    assert not suspects(4.0 * noise(2000), noise_known=True).any()


def test_the_spread_is_that_of_most_samples() -> None:
    residuals = 0.3 * noise(4000, outputs=2)
    residuals[:100] = 30.0
    residuals[:, 1] = np.nan
    found = spread(residuals, noise_known=False)
    assert found[0] == pytest.approx(0.3, rel=0.06) and found[1] == np.inf
    assert spread(residuals, noise_known=True)[0] == 1.0


def test_each_sample_is_counted_once_however_many_windows_hold_it() -> None:
    count = OutlierCount()
    first, second = Outlier(12.0, 0, 9.0), Outlier(12.0, 1, 8.0)
    count.note((first, second), 0.0)
    count.note((first, Outlier(31.0, 0, 7.0)), 10.0)
    count.note((), 40.0)
    assert count.total == 3


def test_words_name_the_largest_with_time_and_size() -> None:
    one = (Outlier(12.3, 1, 10.2),)
    assert words(one, ('h1', 'h2')) == ['1 outlier of h2 at 12.30 s (10.2 sigma) left out']
    many = [Outlier(float(i), 0, 6.0 + i) for i in range(OUTLIERS.told + 1)]
    (said,) = words(many, ('h1', 'h2'))
    assert said.startswith(f'{len(many)} outliers of h1 at 3.00 s (9 sigma), 2.00 s (8 sigma)')
    assert said.endswith('and others left out')
    assert words((), ('h1', 'h2')) == []


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
