"""Tests of obs_ros.observers.papers.adaptation: the kernels beside formulas written in NumPy."""

import numpy as np
import pytest

from obs_ros.observers.papers.adaptation import Workspace, filtered_change, limit_variances
from obs_ros.observers.papers.h_infinity import HInfinityObserver

RNG = np.random.default_rng(11)  # of all numbers here


def workspace(forgetting: float, covariance: float) -> Workspace:
    """That of the suspension with both parameters adapted, and a covariance of some shape."""
    observer = HInfinityObserver('suspension', L=(0.0,) * 12, forgetting=forgetting,
                                 covariance=covariance)  # fmt: skip
    root = RNG.normal(size=(2, 2))
    observer.workspace.P[:] = root @ root.T + np.eye(2)
    return observer.workspace


def test_the_covariance_takes_up_the_information_of_all_outputs() -> None:
    """P^-1 grows by dt (C U)'(C U) after forgetting, output by output or at once."""
    w, seen, e, dt = workspace(0.3, 1e9), RNG.normal(size=(3, 2)), RNG.normal(size=3), 0.01
    grown = np.exp(0.3 * dt) * w.P
    expected = np.linalg.inv(np.linalg.inv(grown) + dt * seen.T @ seen)
    change = filtered_change(w, seen, e, dt)
    np.testing.assert_allclose(w.P, expected, rtol=1e-12)
    np.testing.assert_allclose(change, dt * expected @ seen.T @ e, rtol=1e-12)


def test_an_output_that_is_missing_changes_nothing() -> None:
    w, seen, dt = workspace(0.0, 1e9), RNG.normal(size=(3, 2)), 0.01
    seen[1] = 0.0  # as the observer leaves it
    e = np.array([0.5, np.nan, -0.2])
    change = filtered_change(w, seen, e, dt)
    np.testing.assert_allclose(change, dt * w.P @ (0.5 * seen[0] - 0.2 * seen[2]), rtol=1e-12)


def test_no_variance_exceeds_its_limit_and_correlations_stay() -> None:
    P = np.array([[8.0, 2.0], [2.0, 1.0]])
    before = P[0, 1] / np.sqrt(P[0, 0] * P[1, 1])
    limit_variances(P, 4.0)
    assert P[0, 0] == pytest.approx(4.0) and P[1, 1] == 1.0
    assert P[0, 1] / np.sqrt(P[0, 0] * P[1, 1]) == pytest.approx(before)
    assert P[0, 1] == P[1, 0] and np.linalg.eigvalsh(P).min() > 0.0
