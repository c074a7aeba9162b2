"""Tests of obs_ros.inference.coloured_noise."""

import numpy as np
import pytest
from scipy.linalg import toeplitz
from scipy.optimize import minimize_scalar
from scipy.signal import lfilter

from obs_ros.core.typing import Array
from obs_ros.inference.coloured_noise import EVIDENCE, likeliest_noise

N = 200


def noise(c: float = 0.0, seed: int = 0, size: int = N) -> Array:
    """Noise (size, 1) of unit variance, of correlation c from sample to sample."""
    white = np.random.default_rng([seed, 3]).standard_normal(size + 100)
    return lfilter([np.sqrt(1.0 - c**2)], [1.0, -c], white)[100:, None]


def neg2_log_density(r: Array, c: float) -> float:
    """-2 log p of residuals (N,) but for N log 2 pi, by their covariance (N, N)."""
    covariance = toeplitz(c ** np.arange(r.size))
    return float(np.linalg.slogdet(covariance)[1] + r @ np.linalg.solve(covariance, r))


@pytest.mark.parametrize('seed', range(5))
def test_white_noise_of_the_known_size_has_its_squares(seed: int) -> None:
    assert likeliest_noise(noise(seed=seed)) == pytest.approx(float(np.sum(noise(seed=seed) ** 2)))


@pytest.mark.parametrize('size', [0.3, 3.0])
def test_a_size_that_is_found_costs_a_parameter_each(size: float) -> None:
    r = size * np.hstack([noise(), noise(seed=1)])
    sizes = N * (np.log(np.mean(r**2, axis=0)) + 1.0) + np.log(2 * N)
    assert likeliest_noise(r) == pytest.approx(sizes.sum())


def by_density(r: Array) -> float:
    """Residuals (N,) as correlated noise of unit variance, all prices paid."""
    best = minimize_scalar(lambda c: neg2_log_density(r, c), bounds=(0.0, 0.95), method='bounded')
    return float(best.fun + np.log(r.size) + EVIDENCE)


@pytest.mark.parametrize('c', [0.5, 0.8])
@pytest.mark.parametrize('size', [1.0, 1.3])  # larger noise has no size of its own
def test_correlated_noise_has_its_density_with_all_prices(c: float, size: float) -> None:
    r = noise(c)
    r *= size / r.std()
    assert likeliest_noise(r) == pytest.approx(by_density(r[:, 0]), abs=0.2)
    assert by_density(r[:, 0]) < N * (2.0 * np.log(size) + 1.0)  # that is, than white noise


def test_correlated_noise_may_be_smaller_than_known() -> None:
    r = noise(0.8)
    r *= 0.5 / r.std()
    freed = by_density(2.0 * r[:, 0]) + 2.0 * N * np.log(0.5) + np.log(N)
    assert likeliest_noise(r) == pytest.approx(freed, abs=2.0)


def test_what_was_not_measured_is_left_out() -> None:
    r = np.full((2 * N, 2), np.nan)
    r[::2, 0] = noise(0.8)[:, 0]
    assert likeliest_noise(r) == pytest.approx(likeliest_noise(noise(0.8)))
    assert likeliest_noise(np.full((5, 2), np.nan)) == 0.0 == likeliest_noise(np.zeros((5, 1)))


def test_what_lasts_for_more_than_an_eighth_of_the_samples_is_no_noise() -> None:
    r = noise(0.95, size=60)
    r /= 1.01 * np.sqrt(np.mean(r**2))
    # At most (1 + c) / (1 - c) = 60 / 8 is tried, and explains but part of the correlation.
    assert likeliest_noise(r) > neg2_log_density(r[:, 0], 0.9) + np.log(60) + EVIDENCE
