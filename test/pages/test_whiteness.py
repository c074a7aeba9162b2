import numpy as np
import pytest

from obs_ros.pages.whiteness import SETTINGS, autocorrelation


def coloured(count, pole, seed):
    noise = np.random.default_rng(seed).standard_normal(count)
    for k in range(1, count if pole else 0):
        noise[k] += pole * noise[k - 1]
    return noise


def test_white_noise_is_called_white_as_often_as_the_test_says():
    """Of 1000 series 990 in the mean; both bounds are 4 standard deviations away."""
    found = [autocorrelation(coloured(2000, 0.0, seed)) for seed in range(1000)]
    assert sum(each.white for each in found) == pytest.approx(990, abs=13)
    outside = np.mean([np.abs(each.values) > each.bound for each in found])
    assert outside == pytest.approx(0.05, abs=0.0055)


def test_coloured_noise_has_its_correlations_and_is_named():
    found = autocorrelation(coloured(20_000, 0.6, 0))
    np.testing.assert_allclose(found.values[:4], 0.6 ** np.arange(1, 5), atol=0.04)
    assert found.white is False and found.words.startswith('not white')
    assert found.bound == pytest.approx(1.96 / np.sqrt(20_000))


def test_a_bias_is_seen():
    assert autocorrelation(coloured(400, 0.0, 0) + 0.5).white is False


def test_what_was_not_measured_is_left_out():
    noise = coloured(400, 0.5, 3)
    gaps = np.full(800, np.nan)
    gaps[::2] = noise
    np.testing.assert_array_equal(autocorrelation(gaps).values, autocorrelation(noise).values)


@pytest.mark.parametrize('count', [0, 1, SETTINGS.least - 1])
def test_too_few_are_not_judged(count):
    found = autocorrelation(coloured(count, 0.0, 0))
    assert found.white is None and 'too few' in found.words
    assert np.isfinite(found.values).all()


def test_zeros_are_not_judged():
    found = autocorrelation(np.zeros(500))
    assert found.white is None and not found.values.any()
