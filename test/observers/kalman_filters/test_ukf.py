"""Tests of obs_ros.observers.kalman_filters.ukf: its kernels, on a workspace, by matrices."""

import numpy as np
import pytest
from plants import INTEGRATOR, NAN

from obs_ros import Sample
from obs_ros.core.typing import Array
from obs_ros.observers.kalman_filters.ukf import (
    UnscentedKalmanObserver,
    Workspace,
    draw,
    predict,
    update,
)


def workspace(**settings: float) -> Workspace:
    """That of x' = gain u + drift, y = x, with a covariance that is full."""
    observer = UnscentedKalmanObserver(INTEGRATOR, noise={'y': 0.5}, **settings)
    observer.absorb(Sample(0, u=np.array([1.0]), y=np.array([1.0])))
    kf = observer.workspace
    kf.joint.z[:] = 1.0, 0.9, 0.1
    half = np.random.default_rng(1).standard_normal((3, 3))
    kf.joint.covariance[:] = 0.01 * half @ half.T
    assert draw(kf)
    return kf


def moments(kf: Workspace, points: Array) -> tuple[Array, Array]:
    """Mean and covariance of weighted points (D, 2 D + 1)."""
    of_mean, of_covariance, other, _ = kf.weights
    weights = np.full(points.shape[1], other)
    weights[0] = of_mean
    mean = points @ weights
    weights[0] = of_covariance
    return mean, (points - mean[:, None]) * weights @ (points - mean[:, None]).T


@pytest.mark.parametrize('settings', [{}, {'alpha': 0.5, 'kappa': 1.0, 'beta': 0.0}])
def test_sigma_points_have_mean_and_covariance(settings: dict[str, float]) -> None:
    kf = workspace(**settings)
    mean, covariance = moments(kf, kf.points)
    np.testing.assert_allclose(mean, kf.joint.z, rtol=1e-12)
    np.testing.assert_allclose(covariance, kf.joint.covariance, rtol=1e-9)


def test_the_model_sees_points_within_the_bounds_only() -> None:
    kf = workspace()
    kf.joint.z[0] = kf.joint.high[0]
    draw(kf)
    assert kf.points[0].max() > kf.joint.high[0] == kf.joint.xs[0].max()


def test_no_root_no_points() -> None:
    kf = workspace()
    kf.joint.covariance[0, 0] = -1.0
    assert not draw(kf)
    np.testing.assert_array_equal(kf.points, np.tile(kf.joint.z[:, None], (1, 7)))


def test_predict_takes_the_moments_of_the_propagated_points() -> None:
    """2 s at u = 3: x gains 6 gain + 2 drift."""
    kf = workspace(state_walk=0.01, parameter_walk=0.02)
    z, c = kf.joint.z.copy(), kf.joint.covariance.copy()
    kf.joint.xs[0] += 2.0 * (3.0 * kf.joint.ps[0] + kf.joint.ps[1])
    assert predict(kf, 2.0)
    f = np.array([[1.0, 6.0, 2.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    np.testing.assert_allclose(kf.joint.z, f @ z, rtol=1e-9)
    q = np.diag(np.array([0.01 * 20.0, 0.02 * 2.0, 0.02 * 2.0]) ** 2)
    np.testing.assert_allclose(kf.joint.covariance, f @ c @ f.T + 2.0 * q, rtol=1e-9)


def test_update_corrects_by_the_gain_and_by_nothing_where_nothing_was_measured() -> None:
    kf = workspace()
    z, c = kf.joint.z.copy(), kf.joint.covariance.copy()
    kf.joint.ys[0] = kf.joint.xs[0]
    assert update(kf, np.array([NAN]))
    np.testing.assert_allclose(kf.joint.covariance, c, rtol=1e-9)
    assert kf.joint.surprise[0] == 0.0 and np.isnan(kf.joint.innovation[0])
    assert update(kf, np.array([1.2]))
    gain = c[:, 0] / (c[0, 0] + 0.25)
    np.testing.assert_allclose(kf.joint.z, z + 0.2 * gain, rtol=1e-9)
    np.testing.assert_allclose(kf.joint.covariance, c - np.outer(gain, c[0]), atol=1e-9)
    assert kf.joint.surprise[0] == pytest.approx(0.04 / (c[0, 0] + 0.25), rel=1e-9)
    np.testing.assert_allclose(kf.joint.stddev**2, np.diag(kf.joint.covariance))
