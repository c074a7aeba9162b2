"""Tests of obs_ros.inference.noise."""

from dataclasses import replace

import numpy as np
import pytest
from plants import INTEGRATOR, NAN, OSCILLATOR

from obs_ros import Record
from obs_ros.core.residual_tests import Whiteness, whiteness
from obs_ros.inference.noise import LEARNING, Noise, noise_guess, variances_left
from obs_ros.integration.grid import Grid

OUTPUTS = ('y1', 'y2')


WHITE = Whiteness(0.0, 0.0)


def variances(*deviations: float) -> np.ndarray:
    return np.array(deviations) ** 2


def test_what_is_given_stays() -> None:
    noise = Noise({'y1': 0.1, 'y2': 2.0}, OUTPUTS, learned=False)
    for _ in range(3):
        np.testing.assert_array_equal(noise.scale(), [0.1, 2.0])
        noise.accept(variances(9.0, 9.0), WHITE)


def test_what_is_not_given_is_learned() -> None:
    noise = Noise({'y2': 2.0}, OUTPUTS, learned=False)
    assert noise.scale() is None
    noise.accept(variances(0.3, 9.0), WHITE)
    np.testing.assert_allclose(noise.scale(), [0.3, 2.0])


def test_learned_anew_although_given() -> None:
    """Only the solver begins with what is given; a window's own residual says how far it is off."""
    noise = Noise({'y1': 0.1, 'y2': 2.0}, OUTPUTS, learned=True)
    assert noise.scale() is None
    noise.accept(variances(0.3, 0.4), WHITE)
    np.testing.assert_allclose(noise.scale(), [0.3, 0.4])


def test_the_median_of_the_last_windows() -> None:
    noise = Noise({}, OUTPUTS, learned=False)
    for deviation in (0.1, 0.3, 50.0):
        noise.accept(variances(deviation, 1.0 / deviation), WHITE)
    np.testing.assert_allclose(noise.scale(), [0.3, 1.0 / 0.3])
    for _ in range(LEARNING.remembered):
        noise.accept(variances(7.0, 8.0), WHITE)
    np.testing.assert_allclose(noise.scale(), [7.0, 8.0])
    # Of twenty, ten others are not yet the median.
    for _ in range(LEARNING.remembered // 2 - 1):
        noise.accept(variances(1.0, 1.0), WHITE)
    np.testing.assert_allclose(noise.scale(), [7.0, 8.0])
    for _ in range(2):
        noise.accept(variances(1.0, 1.0), WHITE)
    np.testing.assert_allclose(noise.scale(), [1.0, 1.0])


def test_windows_that_told_the_noise_are_counted_unless_it_is_given() -> None:
    noise = Noise({'y1': 0.1}, OUTPUTS, learned=False)
    given = Noise({'y1': 0.1, 'y2': 2.0}, OUTPUTS, learned=False)
    for count in range(LEARNING.remembered + 3):
        assert noise.told_by == min(count, LEARNING.remembered)
        assert given.told_by == np.inf
        for each in (noise, given):
            each.accept(variances(0.1, 2.0), WHITE)


def test_a_few_odd_windows_teach_nothing() -> None:
    noise = Noise({}, OUTPUTS, learned=False)
    noise.accept(variances(1.0, 1.0), WHITE)
    for _ in range(5):
        for _ in range(LEARNING.patience - 1):
            noise.doubt(variances(5.0, 5.0), WHITE)
        np.testing.assert_allclose(noise.scale(), [1.0, 1.0])
        noise.accept(variances(1.0, 1.0), WHITE)  # they were not in a row
    np.testing.assert_allclose(noise.scale(), [1.0, 1.0])


def test_when_several_in_a_row_are_odd_learning_begins_anew() -> None:
    noise = Noise({}, OUTPUTS, learned=False)
    for _ in range(LEARNING.remembered):
        noise.accept(variances(1.0, 1.0), WHITE)
    for deviation in (5.0, 6.0, 7.0):
        noise.doubt(variances(deviation, 1.0), WHITE)
    np.testing.assert_allclose(noise.scale(), [6.0, 1.0])
    noise.doubt(variances(9.0, 9.0), WHITE)
    np.testing.assert_allclose(noise.scale(), [6.0, 1.0])


def grid(y: np.ndarray) -> Grid:
    t = np.arange(float(len(y)))
    return Grid.of(OSCILLATOR, Record(t, np.zeros(len(y)), y), np.array([0.5, 4.0]))


def test_variances_in_the_units_of_the_outputs() -> None:
    residuals = np.random.default_rng(1).standard_normal((50, 2))
    residuals[::2, 1] = NAN
    y = np.where(np.isfinite(residuals), 1.0, NAN)
    found = variances_left(residuals, grid(y), 6)
    # 75 values less 6 unknowns, of which two thirds are spread over the first output.
    squares = np.nansum((residuals * [0.5, 4.0]) ** 2, axis=0)
    np.testing.assert_allclose(found, squares / [50.0 - 4.0, 25.0 - 2.0])


def test_they_are_unbiased() -> None:
    """Of a straight line through noise of 0.3: over 2000 seeds within 3 standard errors."""
    t = np.arange(12.0)
    basis = np.linalg.qr(np.column_stack([np.ones(12), t]))[0]
    record = Record(t, np.zeros(12), t)
    line = Grid.of(INTEGRATOR, record, np.array([0.3]))
    noise = np.random.default_rng(5).standard_normal((2000, 12))
    left = noise - noise @ basis @ basis.T
    found = [variances_left(r[:, None], line, 2)[0] for r in left]
    error = 0.09 * np.sqrt(2.0 / 10.0 / 2000.0)
    assert abs(np.mean(found) - 0.09) < 3.0 * error


def test_an_output_never_measured_keeps_its_scale() -> None:
    residuals = np.column_stack([np.ones(20), np.full(20, NAN)])
    y = np.column_stack([np.ones(20), np.full(20, NAN)])
    np.testing.assert_allclose(variances_left(residuals, grid(y), 0), [0.25, 16.0])


def test_a_perfect_fit_leaves_what_rounding_does() -> None:
    y = np.full((20, 2), 3.0)
    found = variances_left(np.zeros((20, 2)), grid(y), 4)
    np.testing.assert_allclose(found, (3e-9) ** 2)
    assert (variances_left(np.zeros((20, 2)), grid(0.0 * y), 4) > 0.0).all()


def test_correlation_is_learned_where_windows_are_not_white() -> None:
    noise = Noise({'y1': 0.1, 'y2': 0.1}, OUTPUTS, learned=False)
    assert noise.correlation == 0.0
    for correlation, deviations in ((0.5, 6.0), (0.7, 8.0), (0.6, 7.0), (0.0, 0.1), (0.6, 7.0)):
        noise.accept(variances(0.1, 0.1), Whiteness(correlation, deviations))
    assert noise.correlation == 0.6


def test_what_white_noise_may_well_show_is_no_correlation() -> None:
    noise = Noise({'y1': 0.1, 'y2': 0.1}, OUTPUTS, learned=False)
    rng = np.random.default_rng(1)
    for _ in range(50):
        noise.accept(variances(0.1, 0.1), whiteness(rng.standard_normal((50, 2))))
        assert noise.correlation == 0.0


@pytest.mark.parametrize('sigma', [1e-3, 1.0, 1e3])
def test_a_guess_of_white_noise_is_right(sigma: float) -> None:
    t = np.linspace(0.0, 1.0, 2001)
    y = 5.0 * sigma * np.sin(3.0 * t) + sigma * np.random.default_rng(1).standard_normal(2001)
    y[::7] = NAN
    assert noise_guess(y) == pytest.approx(sigma, rel=0.1)


def test_a_guess_is_positive_where_there_is_no_noise() -> None:
    assert noise_guess(np.full(50, 3.0)) == 1.0
    assert noise_guess(np.linspace(0.0, 1.0, 50)) > 0.01


def test_no_noise_is_below_that_of_rounding() -> None:
    step, floor = 0.4, 0.4 / np.sqrt(12.0)
    slow = np.round(np.linspace(0.0, 3.0, 300) / step) * step
    assert noise_guess(slow) > 0.2, 'most second differences are 0: the spread stands for noise'
    assert noise_guess(slow, rounding=floor) == floor == noise_guess(slow[:2], 0.0, floor)
    noisy = slow + np.random.default_rng(0).standard_normal(300)
    assert noise_guess(noisy, rounding=floor) == pytest.approx(1.0, rel=0.15)
    model = replace(OSCILLATOR, outputs=[replace(v, resolution=step) for v in OSCILLATOR.outputs])
    width = len(model.outputs)
    record = Record(np.arange(9.0), np.zeros((9, 1)), np.zeros((9, width)))
    grid = Grid.of(model, record, np.ones(width))
    left = variances_left(np.full((9, width), 1e-3), grid, 2)
    np.testing.assert_allclose(left, floor**2)
    assert (variances_left(np.full((9, width), 2.0), grid, 2) > 4.0).all()
