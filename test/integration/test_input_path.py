"""Tests of obs_ros.integration.input_path."""

import numpy as np
import pytest

from obs_ros.core.interpolation import segments
from obs_ros.core.model import Interpolation
from obs_ros.core.typing import Array
from obs_ros.integration.input_path import InputPath

T = 0.1 * np.arange(31)


def path(kind: Interpolation = 'hold', seed: int = 0) -> InputPath:
    u = np.random.default_rng(seed).standard_normal((T.size, 2)) + 100.0
    return InputPath(T, *segments(T, u, [kind, kind]))


def value(path: InputPath, column: int, at: Array) -> Array:
    k = np.maximum(np.searchsorted(path.t, at + 1e-12, side='right') - 1, 0)
    return path.u[k, column] + np.maximum(at - path.t[k], 0.0) * path.slope[k, column]


@pytest.mark.parametrize('kind', ['hold', 'linear', 'mean'])
def test_shifted_by_whole_steps_it_is_the_same_path(kind: Interpolation) -> None:
    inputs = path(kind)
    u, slope = inputs.shifted(1, T[10:], np.array([0.0, 0.3, 1.0]))
    for lane, steps in enumerate((0, 3, 10)):
        rows = slice(10 - steps, T.size - 1 - steps)
        assert u[:-1, lane] == pytest.approx(inputs.u[rows, 1], abs=1e-10)
        assert slope[:-1, lane] == pytest.approx(inputs.slope[rows, 1], abs=1e-8)


@pytest.mark.parametrize('kind', ['hold', 'linear', 'mean'])
@pytest.mark.parametrize('delay', [0.013, 0.25, -0.08])
def test_each_step_has_the_integral_and_the_first_moment_of_the_path(
    kind: Interpolation, delay: float
) -> None:
    inputs = path(kind)
    u, slope = inputs.shifted(0, T, np.array([delay]))
    fine = (np.arange(20000) + 0.5) / 20000 * 0.1
    for k in range(T.size - 1):
        exact = value(inputs, 0, T[k] + fine - delay)
        line = u[k, 0] + slope[k, 0] * fine
        assert np.mean(line) == pytest.approx(np.mean(exact), abs=1e-4)
        assert np.mean((line - exact) * fine) == pytest.approx(0.0, abs=1e-5)


def test_before_its_first_sample_an_input_is_as_at_it() -> None:
    inputs = path('linear')
    u, slope = inputs.shifted(0, T, np.array([50.0]))
    assert u[:, 0] == pytest.approx(inputs.u[0, 0], abs=1e-9)
    assert slope[:, 0] == pytest.approx(0.0, abs=1e-7)


def test_values_are_continuous_in_the_delay() -> None:
    inputs = path('hold')
    delays = np.linspace(0.05, 0.25, 2001)
    u, slope = inputs.shifted(0, T, delays)
    assert np.abs(np.diff(u, axis=1)).max() < 0.03  # steps of the input are of 1
    assert np.abs(np.diff(slope, axis=1)).max() < 0.6
