"""The smoothed path of a filter's pass.

The backward recursion of Bryson and Frazier in Bierman's form ("Fixed interval smoothing with
discrete measurements", Int. J. Control 18, 1973): it gives what the smoother of Rauch, Tung and
Striebel gives, but inverts no covariance, and these are singular wherever something does not walk.
From lambda = 0, Lambda = 0 after the last node, back through every update in turn

    lambda <- J' lambda - C' e / S,    Lambda <- J' Lambda J + C' C / S,    J = I - K C,

and through every interval lambda <- F' lambda, Lambda <- F' Lambda F. With mean and covariance
after the updates of a node, z <- z - P lambda and P <- P - P Lambda P.
"""

from typing import NamedTuple

import numpy as np

from obs_ros.core.jit import accelerated
from obs_ros.core.typing import Array, BoolArray
from obs_ros.integration.filter_pass import FilterPass


class Smoothed(NamedTuple):
    """States (K, n), parameters (K, q) and variances (K, n + q) given the whole window.

    A parameter that does not move has its given value and variance 0.
    """

    states: Array
    parameters: Array
    variances: Array


def smoothed(found: FilterPass) -> Smoothed:
    """Return the path of states and moving parameters given all of the window's outputs."""
    means, variances = np.empty_like(found.means), np.empty_like(found.means)
    with np.errstate(all='ignore'):
        smooth(
            found.transition, found.sensitivity, found.gain[:, :, found.index], found.measured,
            found.innovations, found.S, found.means, found.covariances, means, variances,
        )  # fmt: skip
    n, size = found.transition.shape[1], found.gain.shape[2]
    parameters = np.repeat(found.given[None], len(means), axis=0)
    parameters[:, found.moving] = means[:, n:]
    spread = np.zeros((len(means), size))
    spread[:, found.index] = variances
    return Smoothed(means[:, :n], parameters, spread)


def _smooth_on_arrays(
    transition: Array, sensitivity: Array, gain: Array, measured: BoolArray, innovations: Array,
    S: Array, filtered: Array, covariances: Array, means: Array, variances: Array,
) -> None:  # fmt: skip
    """Go back with matrices."""
    d, n = filtered.shape[1], transition.shape[1]
    unit = np.eye(d)
    adjoint, information = np.zeros(d), np.zeros((d, d))
    for k in range(len(filtered) - 1, -1, -1):
        P = covariances[k]
        means[k] = filtered[k] - P @ adjoint
        variances[k] = np.maximum(np.diag(P - P @ information @ P), 0.0)
        for i in np.flatnonzero(measured[k])[::-1]:
            C = sensitivity[k, i]
            J = unit - np.outer(gain[k, i], C)
            adjoint = J.T @ adjoint - C * innovations[k, i] / S[k, i]
            information = J.T @ information @ J + np.outer(C, C) / S[k, i]
        if k > 0:
            F = np.concatenate([transition[k - 1], unit[n:]])
            adjoint, information = F.T @ adjoint, F.T @ information @ F


def _smooth_in_loops(
    transition: Array, sensitivity: Array, gain: Array, measured: BoolArray, innovations: Array,
    S: Array, filtered: Array, covariances: Array, means: Array, variances: Array,
) -> None:  # fmt: skip
    """Go back in loops; PL (d,) is a row of P Lambda."""
    nodes, d = filtered.shape
    adjoint, information, PL = np.zeros(d), np.zeros((d, d)), np.empty(d)
    for k in range(nodes - 1, -1, -1):
        P = covariances[k]
        for a in range(d):
            means[k, a] = filtered[k, a]
            variances[k, a] = P[a, a]
            PL[:] = 0.0
            for b in range(d):
                means[k, a] -= P[a, b] * adjoint[b]
                for c in range(d):
                    PL[c] += P[a, b] * information[b, c]
            for b in range(d):
                variances[k, a] -= PL[b] * P[a, b]
            variances[k, a] = max(variances[k, a], 0.0)
        for i in range(measured.shape[1] - 1, -1, -1):
            if measured[k, i]:
                before(sensitivity[k, i], gain[k, i], innovations[k, i], S[k, i], adjoint,
                       information, PL)  # fmt: skip
        if k > 0:
            back(transition[k - 1], adjoint, information, PL)


@accelerated
def before(
    C: Array, gain: Array, e: float, S: float, adjoint: Array, information: Array, IK: Array
) -> None:
    """Go back through an update: J' Lambda J = Lambda - v C' - C v' + C C' (K v), v = Lambda K."""
    d = C.size
    along, inner = 0.0, 0.0
    for a in range(d):
        IK[a] = 0.0
        for b in range(d):
            IK[a] += information[a, b] * gain[b]
    for a in range(d):
        along += gain[a] * adjoint[a]
        inner += gain[a] * IK[a]
    for a in range(d):
        adjoint[a] -= C[a] * (along + e / S)
        for b in range(d):
            information[a, b] += C[a] * C[b] * (inner + 1.0 / S) - IK[a] * C[b] - C[a] * IK[b]


@accelerated
def back(F: Array, adjoint: Array, information: Array, row: Array) -> None:
    """Go back through an interval: lambda <- F' lambda, Lambda <- F' Lambda F.

    F (n, d) has the rows of a unit matrix below it.
    """
    n, d = F.shape
    for a in range(d):  # Lambda F
        row[:] = 0.0
        for b in range(n, d):
            row[b] = information[a, b]
        for c in range(n):
            for b in range(d):
                row[b] += information[a, c] * F[c, b]
        for b in range(d):  # assigning arrays compiles a message on their shapes, for seconds
            information[a, b] = row[b]
    for b in range(d):  # F' of that
        for a in range(d):
            row[a] = information[a, b] if a >= n else 0.0
            for c in range(n):
                row[a] += F[c, a] * information[c, b]
        for a in range(d):
            information[a, b] = row[a]
    for a in range(d):
        row[a] = adjoint[a] if a >= n else 0.0
        for c in range(n):
            row[a] += F[c, a] * adjoint[c]
    for a in range(d):
        adjoint[a] = row[a]


smooth = accelerated(_smooth_in_loops, _smooth_on_arrays)
