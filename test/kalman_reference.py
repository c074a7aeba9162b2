"""A linear plant with process noise, and its dense Kalman filter and smoother."""

from typing import NamedTuple

import numpy as np
from plants import NAN
from scipy.linalg import expm

from obs_ros import Model, Record, Variable
from obs_ros.core.typing import Array

# A mass pushed by u and a constant load, seen by three outputs.
CART = Model(
    name='cart',
    states=(Variable('s', 'm', -5.0, 5.0), Variable('v', 'm/s', -5.0, 5.0)),
    inputs=(Variable('u'),),
    outputs=(Variable('y1'), Variable('y2'), Variable('y3')),
    parameters=(Variable('gain', lower=0.5, upper=2.0), Variable('load', lower=-2.0, upper=2.0)),
    dynamics=lambda t, x, u, p: (x[1], p[0] * u[0] + p[1]),
    output=lambda t, x, u, p: (x[0], x[1] + 0.3 * p[1], 0.5 * x[0] - 0.7 * x[1]),
)
A = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, 0.0]])  # of s, v, load
C = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.3], [0.5, -0.7, 0.0]])
X0, P = np.array([0.3, -0.2]), np.array([1.2, 0.4])
WALKS, NOISE = np.array([0.1, 0.3, 0.0, 0.0]), np.array([0.05, 0.1, 0.2])
PRIOR = np.zeros((4, 4))
PRIOR[np.ix_([0, 1, 3], [0, 1, 3])] = [[0.1, 0.05, 0.0], [0.05, 0.2, 0.02], [0.0, 0.02, 0.3]]


class Dense(NamedTuple):
    """A Kalman filter's path: -2 log p(y), innovations' covariances, means, covariances."""

    neg2_log_likelihood: float
    S: list[Array]
    means: Array
    covariances: Array


def cart_window(seed: int = 0) -> Record:
    """Irregular samples, some missing."""
    rng = np.random.default_rng(seed)
    t = np.concatenate([[0.0], np.cumsum(rng.uniform(0.02, 0.3, 60))])
    y = rng.standard_normal((61, 3))
    y[rng.random((61, 3)) < 0.3] = NAN
    y[[5, 60]] = NAN
    return Record(t, rng.standard_normal((61, 1)), y)


def transition(dt: float) -> tuple[Array, Array]:
    """Transition and noise of an interval by Van Loan's matrix exponential."""
    noise = np.diag([WALKS[0], WALKS[1], WALKS[3]]) ** 2
    block = expm(dt * np.block([[-A, noise], [np.zeros((3, 3)), A.T]]))
    F = block[3:, 3:].T
    return F, F @ block[:3, 3:]


def dense_filter(record: Record) -> Dense:
    """The joint update of all measured outputs, and exact discretisation."""
    z, cov, total = np.array([*X0, P[1]]), PRIOR[np.ix_([0, 1, 3], [0, 1, 3])], 0.0
    innovation_covariances, means, covariances = [], [], []
    for k, y in enumerate(record.y):
        if k > 0:
            dt = record.t[k] - record.t[k - 1]
            F, Q = transition(dt)
            push = P[0] * record.u[k - 1, 0]
            z = F @ z + push * np.array([0.5 * dt * dt, dt, 0.0])
            cov = F @ cov @ F.T + Q
        seen = np.isfinite(y)
        S = C[seen] @ cov @ C[seen].T + np.diag(NOISE[seen] ** 2)
        if seen.any():
            e = y[seen] - C[seen] @ z
            K = np.linalg.solve(S, C[seen] @ cov).T
            z, cov = z + K @ e, cov - K @ S @ K.T
            total += np.linalg.slogdet(S)[1] + e @ np.linalg.solve(S, e)
        innovation_covariances.append(S)
        means.append(z)
        covariances.append(cov)
    return Dense(total, innovation_covariances, np.array(means), np.array(covariances))


def dense_smoother(record: Record, dense: Dense) -> tuple[Array, Array]:
    """Smoothed means (K, 3) and covariances (K, 3, 3) by Rauch, Tung & Striebel 1965."""
    means, covariances = dense.means.copy(), dense.covariances.copy()
    for k in range(len(means) - 2, -1, -1):
        dt = record.t[k + 1] - record.t[k]
        F, Q = transition(dt)
        push = P[0] * record.u[k, 0] * np.array([0.5 * dt * dt, dt, 0.0])
        predicted = F @ dense.covariances[k] @ F.T + Q
        G = np.linalg.solve(predicted, F @ dense.covariances[k]).T
        means[k] = dense.means[k] + G @ (means[k + 1] - F @ dense.means[k] - push)
        covariances[k] += G @ (covariances[k + 1] - predicted) @ G.T
    return means, covariances


class Considered(NamedTuple):
    """A filter whose parameters are considered: states (K, 2), covariances (K, 4, 4), innovations.

    Innovations (K, 3) and their variances (K, 3) are of all outputs of an instant at once.
    """

    states: Array
    covariances: Array
    innovations: Array
    S: Array


def considered_filter(record: Record, cov: Array) -> Considered:
    """Outputs one after the other, gains of gain and load 0; exact discretisation; cov (4, 4)."""
    z, found = np.array([*X0, *P]), []
    outputs = np.insert(C, 2, 0.0, axis=1)  # of s, v, gain, load
    for k, y in enumerate(record.y):
        if k > 0:
            rate = np.zeros((4, 4))
            rate[0, 1], rate[1, 2:] = 1.0, [record.u[k - 1, 0], 1.0]
            dt, noise = record.t[k] - record.t[k - 1], np.diag([*WALKS[:2], 0.0, 0.0]) ** 2
            block = expm(dt * np.block([[-rate, noise], [np.zeros((4, 4)), rate.T]]))
            F = block[4:, 4:].T
            z, cov = F @ z, F @ cov @ F.T + F @ block[:4, 4:]
        seen = np.isfinite(y)
        e = np.where(seen, y - outputs @ z, NAN)
        S = np.where(seen, np.diagonal(outputs @ cov @ outputs.T) + NOISE**2, NAN)
        for i in np.flatnonzero(seen) if k > 0 else ():
            h = outputs[i]
            K = cov @ h / (h @ cov @ h + NOISE[i] ** 2) * [1.0, 1.0, 0.0, 0.0]
            z = z + K * (y[i] - h @ z)
            J = np.eye(4) - np.outer(K, h)
            cov = J @ cov @ J.T + NOISE[i] ** 2 * np.outer(K, K)
        found.append((z[:2], cov, e, S))
    return Considered(*(np.array(part) for part in zip(*found, strict=True)))
