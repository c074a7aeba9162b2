"""Tests of obs_ros.inference.assessment.fit."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from plants import NAN, OSCILLATOR, window_of
from scipy.signal import lfilter

from obs_ros import Record
from obs_ros.core.residual_tests import inflation, whiteness
from obs_ros.core.typing import Array
from obs_ros.inference.assessment.fit import Fit, root_mean_square

T = np.linspace(0.0, 2.0, 201)
VALUES = 402 - 4  # measured ones less the unknowns


def fit_of(residuals: Array, *, noise_known: bool = True, **colour: Any) -> Fit:
    record = Record(T, np.zeros(201), np.sin(T)[:, None] * np.ones(2))
    objective = window_of(OSCILLATOR, record, 0.1)
    squares = float(np.nansum(residuals**2))
    return Fit.of(objective, squares, residuals, noise_known=noise_known, **colour)


def white(scale: float = 1.0, seed: int = 0) -> Array:
    return scale * np.random.default_rng(seed).standard_normal((201, 2))


@pytest.mark.parametrize(
    ('scale', 'too_large', 'too_small'),
    [(1.0, False, False), (1.3, True, False), (0.7, False, True)],
)
def test_its_size_beside_the_noise(scale: float, too_large: bool, too_small: bool) -> None:
    found = fit_of(white(scale))
    assert found.ratio == pytest.approx(scale, rel=0.1)
    assert (found.too_large, found.too_small) == (too_large, too_small)
    assert found.colour.white
    assert found.is_noise == (not too_large)
    guessed = fit_of(white(scale), noise_known=False)
    assert not guessed.too_large and not guessed.too_small


def test_noise_of_a_known_colour_counts_as_fewer_squares() -> None:
    found, plain = fit_of(white(), correlation=0.5), fit_of(white())
    assert plain.freedom == VALUES
    # (1 - rho^2) / (1 + rho^2) independent ones; the scale was enlarged by (1 + rho) / (1 - rho).
    assert found.freedom == pytest.approx(0.6 * VALUES)
    assert found.squares == pytest.approx(0.6 * 3.0 * plain.squares)


def test_the_colour_of_a_noise_whose_size_is_given_is_no_misfit() -> None:
    coloured = lfilter([0.8], [1.0, -0.6], white(), axis=0)
    scaled = coloured / np.sqrt(inflation(0.6))  # of white noise that would disturb as much
    assert not fit_of(coloured).is_noise and not fit_of(scaled, correlation=0.6).is_noise
    found = fit_of(scaled, correlation=0.6, noise_given=True)
    assert found.is_noise and found.white and not found.colour.white and found.inflation == 1.0
    slower = lfilter([0.44], [1.0, -0.9], white(), axis=0) / np.sqrt(inflation(0.6))
    assert not fit_of(slower, correlation=0.6, noise_given=True).white


def test_rounding_is_negligible_and_a_signal_is_not() -> None:
    assert fit_of(white(1e-7)).negligible
    coloured = np.cumsum(white(), axis=0)
    assert fit_of(1e-8 * coloured).is_noise and not fit_of(0.01 * coloured).is_noise
    assert not fit_of(white(1e-2)).negligible


def test_rms_of_an_output_never_measured_is_zero() -> None:
    residuals = np.array([[3.0, NAN], [NAN, NAN], [4.0, NAN]])
    np.testing.assert_allclose(root_mean_square(residuals), [np.sqrt(12.5), 0.0])


def test_what_outliers_would_have_added_is_not_missed() -> None:
    fit = Fit(100.0, 200.0, whiteness(np.zeros((3, 1))), 1.0, noise_known=True, negligible=False)
    assert fit.too_small
    assert not replace(fit, trimmed=True).too_small


def test_a_sensor_that_rounds_more_coarsely_than_its_noise_may_leave_less() -> None:
    fit = Fit(100.0, 200.0, whiteness(np.zeros((3, 1))), 1.0, noise_known=True, negligible=False)
    assert not replace(fit, rounded=True).too_small
