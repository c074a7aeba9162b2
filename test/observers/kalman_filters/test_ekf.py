"""Tests of obs_ros.observers.kalman_filters.ekf: its kernels, on a workspace, by matrices."""

import numpy as np
import pytest
from plants import INTEGRATOR, NAN

from obs_ros import Sample
from obs_ros.observers.kalman_filters.ekf import (
    ExtendedKalmanObserver,
    Workspace,
    joseph,
    predict,
    spread,
    update,
)


def workspace(**settings: float) -> Workspace:
    """That of x' = gain u + drift, y = x, with a covariance that is full."""
    observer = ExtendedKalmanObserver(INTEGRATOR, noise={'y': 0.5}, **settings)
    observer.absorb(Sample(0, u=np.array([1.0]), y=np.array([1.0])))
    kf = observer.workspace
    kf.joint.z[:] = 1.0, 0.9, 0.1
    half = np.random.default_rng(1).standard_normal((3, 3))
    kf.joint.covariance[:] = 0.01 * half @ half.T
    spread(kf)
    return kf


def test_joseph_s_form() -> None:
    rng = np.random.default_rng(2)
    half, h, gain = rng.standard_normal((4, 4)), rng.standard_normal(4), rng.standard_normal(4)
    c = half @ half.T
    left = np.eye(4) - np.outer(gain, h)
    expected = left @ c @ left.T + 0.3 * np.outer(gain, gain)
    joseph(c, h, c @ h, gain, 0.3)
    np.testing.assert_allclose(c, expected, atol=1e-12)
    np.testing.assert_array_equal(c, c.T)


def test_candidates_lie_a_step_from_the_mean_but_within_its_bounds() -> None:
    kf = workspace()
    np.testing.assert_allclose(kf.gaps, 2.0 * kf.steps, rtol=1e-6)
    kf.joint.z[0] = kf.joint.high[0]
    spread(kf)
    assert kf.joint.xs[0, 1] == kf.joint.high[0] > kf.joint.xs[0, 2]
    assert kf.gaps[0] == pytest.approx(kf.steps[0], rel=1e-6)
    np.testing.assert_array_equal(kf.joint.xs[0, 3:], kf.joint.z[0])
    gain, drift = kf.joint.rows
    assert kf.joint.ps[gain, 3] - kf.joint.ps[gain, 4] == kf.gaps[1]
    assert kf.joint.ps[drift, 5] - kf.joint.ps[drift, 6] == kf.gaps[2]


def test_predict_takes_the_derivatives_of_the_step() -> None:
    """2 s at u = 3: x gains 6 gain + 2 drift."""
    kf = workspace(state_walk=0.01, parameter_walk=0.02)
    z, c = kf.joint.z.copy(), kf.joint.covariance.copy()
    kf.joint.xs[0] += 2.0 * (3.0 * kf.joint.ps[0] + kf.joint.ps[1])
    assert predict(kf, 2.0)
    f = np.array([[1.0, 6.0, 2.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    np.testing.assert_allclose(kf.joint.z, f @ z, rtol=1e-12)
    q = np.diag(np.array([0.01 * 20.0, 0.02 * 2.0, 0.02 * 2.0]) ** 2)
    np.testing.assert_allclose(kf.joint.covariance, f @ c @ f.T + 2.0 * q, rtol=1e-6)


def test_update_corrects_by_the_gain_and_by_nothing_where_nothing_was_measured() -> None:
    kf = workspace()
    z, c = kf.joint.z.copy(), kf.joint.covariance.copy()
    kf.joint.ys[0] = kf.joint.xs[0]
    assert update(kf, np.array([NAN]))
    np.testing.assert_array_equal(kf.joint.covariance, c)
    assert kf.joint.surprise[0] == 0.0 and np.isnan(kf.joint.innovation[0])
    assert update(kf, np.array([1.2]))
    gain = c[:, 0] / (c[0, 0] + 0.25)
    np.testing.assert_allclose(kf.joint.z, z + 0.2 * gain, rtol=1e-6)
    np.testing.assert_allclose(kf.joint.covariance, c - np.outer(gain, c[0]), atol=1e-9)
    assert kf.joint.surprise[0] == pytest.approx(0.04 / (c[0, 0] + 0.25), rel=1e-6)
    np.testing.assert_allclose(kf.joint.stddev**2, np.diag(kf.joint.covariance))
