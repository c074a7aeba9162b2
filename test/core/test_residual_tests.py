"""Tests of obs_ros.core.residual_tests."""

import numpy as np
import pytest
from plants import NAN
from scipy.stats import chi2, f

from obs_ros.core.residual_tests import (
    changes_slowly,
    independent_share,
    inflation,
    is_white,
    like_noise,
    squares_of,
    too_small,
    whiteness,
)


def test_correlation_of_a_sequence_by_hand() -> None:
    found = whiteness(np.array([[1.0], [2.0], [-1.0], [0.5]]))
    assert found.correlation == pytest.approx((2.0 - 2.0 - 0.5) / (1.0 + 4.0 + 1.0 + 0.25))
    assert found.deviations == pytest.approx(found.correlation * 2.0)


def test_outputs_are_pooled_and_gaps_closed() -> None:
    residuals = np.array([[1.0, NAN], [NAN, 3.0], [2.0, 3.0], [-1.0, NAN]])
    found = whiteness(residuals)
    # 1, 2, -1 and 3, 3.
    assert found.correlation == pytest.approx((2.0 - 2.0 + 9.0) / (6.0 + 18.0))
    assert found.deviations == pytest.approx(found.correlation * 5.0**0.5)


def test_nothing_left_is_white() -> None:
    assert is_white(np.zeros((10, 2)))
    assert is_white(np.full((10, 2), NAN))


def test_noise_is_hardly_ever_taken_for_a_mismatch() -> None:
    """1000 windows of 2 x 150, seed 1: 5 in 1000 expected, at most 15 allowed."""
    noise = np.random.default_rng(1).standard_normal((1000, 150, 2))
    assert sum(not is_white(window) for window in noise) <= 15


def test_white_noise_is_white_and_a_trend_is_not() -> None:
    rng = np.random.default_rng(4)
    verdicts = [is_white(rng.standard_normal((200, 2))) for _ in range(1000)]
    assert 0.98 < np.mean(verdicts) <= 1.0  # 0.995 is meant
    trend = rng.standard_normal((200, 2)) + np.linspace(-1.0, 1.0, 200)[:, None]
    assert not is_white(trend)


def test_the_verdict_is_a_bool_since_reports_ask_whether_it_is_false() -> None:
    assert is_white(np.tile([1.0, -1.0], 50)[:, None]) is False
    assert is_white(np.zeros((5, 1))) is True


def test_missing_residuals_do_not_matter() -> None:
    rng = np.random.default_rng(5)
    residuals = rng.standard_normal((200, 2))
    residuals[rng.random((200, 2)) < 0.5] = np.nan
    assert is_white(residuals)
    assert is_white(np.full((5, 2), np.nan))
    assert is_white(np.zeros((5, 1)))


@pytest.mark.parametrize('r', [0.3, -0.3])
def test_autoregressive_noise_is_found(r: float) -> None:
    """Each of 100 windows of 300, seed 2: 5.2 standard deviations expected, 2.81 needed."""
    rng = np.random.default_rng(2)
    found = 0
    for _ in range(100):
        white = rng.standard_normal(300)
        noise = np.empty(300)
        noise[0] = white[0]
        for k in range(1, 300):
            noise[k] = r * noise[k - 1] + white[k]
        colour = whiteness(noise[:, None])
        found += not colour.white and colour.correlation * r > 0.0
    assert found >= 95


@pytest.mark.parametrize('freedom', [1, 20, 600, 20000])
def test_squares_against_chi_square(freedom: int) -> None:
    upper, lower = chi2.isf(0.001, freedom), chi2.ppf(0.001, freedom)
    assert like_noise(upper * (1.0 - 1e-9), freedom)
    assert not like_noise(upper * (1.0 + 1e-9), freedom)
    assert too_small(lower * (1.0 - 1e-6), freedom)
    assert not too_small(lower * (1.0 + 1e-6), freedom)


@pytest.mark.parametrize('told', [20.0, 140.0, 2800.0])
def test_squares_against_f_where_few_values_told_the_noise(told: float) -> None:
    upper = 140.0 * f.ppf(0.999, 140, told)
    assert like_noise(upper * (1.0 - 1e-6), 140, told)
    assert not like_noise(upper * (1.0 + 1e-6), 140, told)
    assert like_noise(chi2.ppf(0.999, 140), 140, told)


def test_without_freedom_it_counts_as_one() -> None:
    assert like_noise(10.0, 0) and like_noise(10.0, -3)
    assert not like_noise(11.0, 0)
    assert not too_small(0.0, 0)


@pytest.mark.parametrize('r', [0.0, 0.3, 0.6])
def test_correlated_noise_disturbs_means_and_squares_as_said(r: float) -> None:
    """Of 4000 stretches of 400 samples, autoregressive: variances of mean and sum of squares."""
    rng = np.random.default_rng(5)
    noise = rng.standard_normal((4000, 400))
    for k in range(1, 400):
        noise[:, k] = r * noise[:, k - 1] + np.sqrt(1.0 - r**2) * noise[:, k]
    assert 400.0 * noise.mean(axis=1).var() == pytest.approx(inflation(r), rel=0.08)
    squares = (noise**2).sum(axis=1)
    assert 800.0 / squares.var() == pytest.approx(independent_share(r), rel=0.08)


def test_negative_correlation_counts_as_none() -> None:
    assert (inflation(-0.4), independent_share(-0.4)) == (1.0, 1.0)


def test_what_changes_slowly_below_the_noise_is_seen_though_neighbours_tell_little() -> None:
    rng = np.random.default_rng(0)
    noise = rng.standard_normal((200, 500, 2))
    slow = 0.25 * np.sqrt(2.0) * np.sin(2.0 * np.pi * np.arange(500) / 250)[:, None]
    assert np.mean([changes_slowly(r) for r in noise]) < 0.05
    assert np.mean([changes_slowly(r + slow) for r in noise]) > 0.95
    assert np.mean([is_white(r + slow) for r in noise]) > 0.7


def test_few_values_or_none_change_as_they_like() -> None:
    assert not changes_slowly(np.linspace(-1.0, 1.0, 12)[:, None])
    assert not changes_slowly(np.full((100, 1), np.nan))
    assert not changes_slowly(np.zeros((100, 1)))


def test_squares_of_what_was_measured_are_summed_by_output() -> None:
    counts, squares = squares_of(np.array([[1.0, NAN], [2.0, 3.0], [NAN, np.inf]]))
    assert counts.tolist() == [2, 1] and squares.tolist() == [5.0, np.inf]
