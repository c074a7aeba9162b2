"""Tests of obs_ros.observers.innovation_gate: outputs admitted, and observers with a gate."""

import math
from typing import Any

import numpy as np
import pytest
from plants import LAG, lag_outputs, square_wave

from obs_ros import Sample, Variable
from obs_ros.inference.innovation_gate import Gate
from obs_ros.integration.path import Path
from obs_ros.integration.stepper import stepper_for
from obs_ros.observers.innovation_gate import Admission, expected_outputs, root_mean_square
from obs_ros.observers.kalman_filters.ekf import ExtendedKalmanObserver
from obs_ros.observers.kalman_filters.ukf import UnscentedKalmanObserver

SIGMA, T = 0.05, 0.1 * np.arange(400)
TRUTH = (1.2, 3.0)
OUTPUTS = (Variable('h1'), Variable('h2'))


def test_outputs_are_admitted_counted_and_told() -> None:
    admission = Admission(Gate.of(2, 5.0, 9), OUTPUTS, np.array([0.1, math.nan]))
    assert admission.judges
    for k in range(6):
        y = np.array([2.0, 9.0])
        admission.admit(y, np.zeros(2), filled=k == 0)
        admission.note(float(k))
        np.testing.assert_array_equal(y, [0.0 if k == 0 else math.nan, 9.0])
    assert admission.counts == {'outlier.h1': 6, 'burst.h1': 1, 'outlier.h2': 0, 'burst.h2': 0}
    assert admission.last == 'h1 at 5.00 s (20 sigma)'
    assert not Admission(Gate.of(1, 5.0, 9), OUTPUTS[:1], np.array([math.nan])).judges
    assert not Admission(Gate.of(1, 0.0, 9), OUTPUTS[:1], np.array([0.1])).judges


def test_errors_of_the_state_pass_as_they_change_slowly() -> None:
    admission = Admission(Gate.of(1, 5.0, 9), OUTPUTS[:1], np.array([0.1]))
    for k in range(60):  # 20 times the noise in the end
        y = np.array([2.0 * k / 60.0])
        admission.admit(y, np.zeros(1), filled=False)
        assert not admission.note(float(k))
    y = np.array([5.0])
    admission.admit(y, np.zeros(1), filled=False)
    assert admission.note(60.0) and np.isnan(y[0]) and admission.innovation[0] == 5.0
    admission.clear()
    assert not admission.gate.rejected.any()


@pytest.mark.parametrize('backend', ['numpy', None])
def test_the_model_expects_its_outputs(backend: Any) -> None:
    path = Path(1, np.array([0.0, 0.5]), np.full(2, 0.5), np.full(2, 5), np.ones((2, 1)),
                np.zeros((2, 1)))  # fmt: skip
    found = expected_outputs(
        stepper_for(LAG, backend), path, 0.5, np.ones(1), np.array([0.2]), np.array(TRUTH)
    )
    decay = math.exp(-0.5 / 3.0)
    np.testing.assert_allclose(found, [decay * 0.2 + (1.0 - decay) * 1.2], rtol=1e-6)


def test_the_root_mean_square_is_of_numbers() -> None:
    assert root_mean_square([3.0, math.nan, 4.0]) == pytest.approx(math.sqrt(12.5))
    assert math.isnan(root_mean_square([math.nan]))


def observed(kind: Any, y: np.ndarray, **settings: float) -> tuple[Any, np.ndarray]:
    """Counts and the last outlier of an observer of outputs y (K, 1), and its k and tau (K, 2)."""
    observer = kind(LAG, noise={'y': SIGMA}, backend='numpy', **settings)
    u, found, estimate = square_wave(T), [], None
    for k, t in enumerate(T):
        observer.absorb(Sample(round(t * 1e9), u=np.atleast_1d(u[k]), y=y[k]))
        estimate = observer.estimate() or estimate  # None where nothing was measured
        found.append(list(estimate.parameters.values()))
    return (observer.counts, estimate.last_outlier), np.array(found)


def measured() -> np.ndarray:
    y = lag_outputs(T, square_wave(T), 0.5, np.tile(TRUTH, (T.size - 1, 1)))
    return y.reshape(-1, 1) + SIGMA * np.random.default_rng(3).standard_normal((T.size, 1))


@pytest.mark.parametrize('kind', [ExtendedKalmanObserver, UnscentedKalmanObserver])
def test_a_filter_is_not_moved_by_outliers(kind: Any) -> None:
    clean = measured()
    spoiled = clean.copy()
    far = np.arange(150, 400, 40)
    spoiled[far] += 100.0 * SIGMA
    _, without = observed(kind, np.where(clean == spoiled, clean, np.nan))
    (counts, last), gated = observed(kind, spoiled)
    _, open_ = observed(kind, spoiled, innovation_gate=0.0)
    np.testing.assert_allclose(gated, without, atol=1e-3)
    assert np.abs(open_ - without).max() > 5.0 * np.abs(gated - without).max()
    assert counts['outlier.y'] == far.size and counts['burst.y'] == 0
    assert last.startswith(f'y at {T[far[-1]]:.2f} s (')


@pytest.mark.parametrize('kind', [ExtendedKalmanObserver, UnscentedKalmanObserver])
def test_a_filter_widens_instead_of_starving(kind: Any) -> None:
    """The plant's gain doubles, which a filter that is sure of it would never believe."""
    p = np.tile(TRUTH, (T.size - 1, 1))
    p[200:, 0] *= 2.0
    y = lag_outputs(T, square_wave(T), 0.5, p).reshape(-1, 1)
    y += SIGMA * np.random.default_rng(3).standard_normal(y.shape)
    (counts, _), found = observed(kind, y, parameter_walk=1e-5)
    _, ungated = observed(kind, y, parameter_walk=1e-5, innovation_gate=0.0)
    np.testing.assert_allclose(found[230:], ungated[230:], atol=0.15)
    assert 0 < counts['outlier.y'] < 20
