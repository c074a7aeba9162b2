"""Tests of obs_ros.inference.assessment.parabola."""

from typing import Any

import numpy as np
from problems import linear, rows_of

from obs_ros.core.typing import Array
from obs_ros.inference.assessment.parabola import parabola_holds

LEVEL = 3.84


def holds(posterior: Any, z: Array, gradient: Array, covariance: Array) -> bool:
    return parabola_holds(posterior, z, gradient, covariance, np.arange(z.size), LEVEL)


def test_the_parabola_holds_where_it_is_the_cost() -> None:
    posterior, z, covariance = linear()
    zero = np.zeros(4)
    assert holds(posterior, z, zero, covariance)
    # The cost grows by the inverse of the factor: 20 % may be amiss.
    assert holds(posterior, z, zero, 1.15 * covariance)
    assert not holds(posterior, z, zero, 1.25 * covariance)
    assert not holds(posterior, z, zero, 0.75 * covariance)
    assert not holds(posterior, z, zero, np.full((4, 4), np.nan))


def test_it_holds_from_beside_the_optimum_where_the_gradient_says_so() -> None:
    posterior, z, covariance = linear()
    beside = z + 0.3 * np.sqrt(np.diagonal(covariance))
    gradient = np.linalg.solve(covariance, beside - z)
    assert holds(posterior, beside, gradient, covariance)
    assert not holds(posterior, beside, np.zeros(4), covariance)


def test_it_does_not_where_it_leaves_the_box() -> None:
    posterior, z, covariance = linear()
    reach = np.sqrt(LEVEL * covariance[2, 2])
    posterior.limits[1, 2] = z[2] + 1.01 * reach
    assert holds(posterior, z, np.zeros(4), covariance)
    posterior.limits[1, 2] = z[2] + 0.99 * reach
    assert not holds(posterior, z, np.zeros(4), covariance)


def test_of_others_it_need_not_hold() -> None:
    """Bent is the cost of the last unknown alone, on which the others do not lean."""
    posterior = rows_of(lambda z: [(z[:, 0] - 0.5) / 0.05, (z[:, 1] - 0.5) ** 3 / 1e-4])
    z, covariance = np.full(2, 0.5), np.diag([0.05, 0.05]) ** 2
    for pinned, expected in (([0], True), ([1], False), ([0, 1], False), ([], True)):
        places = np.array(pinned, dtype=np.int64)
        found = parabola_holds(posterior, z, np.zeros(2), covariance, places, LEVEL)
        assert found is expected


def test_along_a_bent_valley_it_does_not() -> None:
    """Of a and b the product is known, and a little of a."""
    rows = rows_of(lambda z: [(z[:, 0] * z[:, 1] - 0.25) / 0.01, (z[:, 0] - 0.5) / 0.12])
    jacobian = np.array([[50.0, 50.0], [1.0 / 0.12, 0.0]])
    covariance = np.linalg.inv(jacobian.T @ jacobian)
    assert not holds(rows, np.full(2, 0.5), np.zeros(2), covariance)


def test_where_the_model_diverges_it_does_not() -> None:
    rows = rows_of(lambda z: [np.where(z[:, 0] < 0.55, (z[:, 0] - 0.5) / 0.05, np.inf)], 1)
    assert not holds(rows, np.full(1, 0.5), np.zeros(1), np.full((1, 1), 0.05**2))
