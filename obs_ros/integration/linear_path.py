"""The likelihood of process and measurement noise along a linearised window: only matrices.

Along a filter's pass, with w_k = y_k - h(z_k) at the predictions z_k and their corrections c_k, a
filter for other noise is off by delta (d,), to first order (exactly so for linear plants):

    delta <- F delta;    e_i = w_i - C_i delta,  delta <- delta + K_i e_i  for each i;
    delta <- delta - c_k

with S and K as of `FilterPass`. Sixteen sets of noise side by side take as long as one.
"""

from dataclasses import dataclass

import numpy as np

from obs_ros.core.jit import accelerated
from obs_ros.core.typing import Array, BoolArray
from obs_ros.integration.filter_pass import FilterPass
from obs_ros.integration.path import LANES, lanes


@dataclass(frozen=True)
class LinearPath:
    """A window linearised along a pass: raw residuals (K, r) and corrections (K, d) besides it."""

    along: FilterPass
    residuals: Array
    corrections: Array

    @classmethod
    def of(cls, found: FilterPass) -> 'LinearPath':
        """Linearise along a pass."""
        errors = np.where(found.measured, found.innovations, 0.0)
        return cls(
            found,
            errors + np.einsum('kij,kj->ki', found.cross, errors),
            np.einsum('kid,ki->kd', found.gain[:, :, found.index], errors),
        )

    def neg2_log_likelihood(self, walks: Array, noise: Array) -> Array:
        """Return sum of log S + e^2 / S (B,) of walks (n + q, B) and noise (r, B).

        Units are as of `Kernels.filter`. Only what the pass linearised may walk: other parameters'
        walks are left aside. Infinite where the sum is not finite.
        """
        found, count = self.along, walks.shape[1]
        Q, R = np.empty((found.index.size, lanes(count))), np.empty((len(noise), lanes(count)))
        for variances, deviations in ((Q, walks[found.index]), (R, noise)):
            variances[:, :count] = deviations**2
            variances[:, count:] = variances[:, count - 1 : count]
        out = np.empty(lanes(count))
        with np.errstate(all='ignore'):
            likelihoods(
                found.dt, found.transition, found.sensitivity, found.measured, self.residuals,
                self.corrections, found.prior, Q, R, out,
            )  # fmt: skip
        return np.where(np.isfinite(out), out, np.inf)[:count]


def _likelihoods_on_arrays(
    dt: Array, transition: Array, sensitivity: Array, measured: BoolArray, residuals: Array,
    corrections: Array, prior: Array, Q: Array, R: Array, out: Array,
) -> None:  # fmt: skip
    """Compute the likelihoods with one matrix for each set of noise."""
    n, d = transition.shape[1:]
    unit = np.eye(d)
    spread = unit * Q.T[:, None, :]
    P, delta = np.broadcast_to(prior, spread.shape), np.zeros((out.size, d))
    out[:] = 0.0
    for k in range(len(measured)):
        if k > 0:
            F = np.concatenate([transition[k - 1], unit[n:]])
            noises = spread + (unit + F) @ spread @ (unit + F).T + F @ spread @ F.T
            P = F @ P @ F.T + dt[k - 1] / 6.0 * noises
            delta = delta @ F.T
        for i in np.flatnonzero(measured[k]):
            C = sensitivity[k, i]
            PC = P @ C
            S = PC @ C + R[i]
            e = residuals[k, i] - delta @ C
            delta = delta + PC * (e / S)[:, None]
            P = P - PC[:, :, None] * PC[:, None, :] / S[:, None, None]
            out += np.log(S) + e * e / S
        delta = delta - corrections[k]


def _likelihoods_in_loops(
    dt: Array, transition: Array, sensitivity: Array, measured: BoolArray, residuals: Array,
    corrections: Array, prior: Array, Q: Array, R: Array, out: Array,
) -> None:  # fmt: skip
    """Compute the likelihoods of a chunk at a time, its lanes innermost."""
    n, d = transition.shape[1], transition.shape[2]
    P, FP = np.empty((d, d, LANES)), np.empty((d, d, LANES))
    delta, row, e, S = np.empty((d, LANES)), np.empty((d, LANES)), np.empty(LANES), np.empty(LANES)
    product, total = np.empty(LANES), np.empty(LANES)
    for first in range(0, out.size, LANES):
        q, noise = Q[:, first : first + LANES].copy(), R[:, first : first + LANES].copy()
        for a in range(d):
            delta[a, :] = 0.0
            for b in range(d):
                P[a, b, :] = prior[a, b]
        product[:], total[:], factors = 1.0, 0.0, 0
        for k in range(len(measured)):
            if k > 0:
                predict(transition[k - 1], dt[k - 1], q, n, P, FP, delta, row)
            for i in range(measured.shape[1]):
                if measured[k, i]:
                    e[:], S[:] = residuals[k, i], noise[i]
                    update(sensitivity[k, i], P, row, delta, e, S)
                    for lane in range(LANES):
                        total[lane] += e[lane] * e[lane] / S[lane]
                        product[lane] *= S[lane]
                    factors += 1
                    if factors % 8 == 0:  # a logarithm costs more than all the rest
                        total += np.log(product)
                        product[:] = 1.0
            for a in range(d):
                for lane in range(LANES):
                    delta[a, lane] -= corrections[k, a]
        out[first : first + LANES] = total + np.log(product)


@accelerated
def predict(
    F: Array, dt: float, Q: Array, n: int, P: Array, FP: Array, delta: Array, row: Array
) -> None:
    """Turn P (d, d, L) into F (P + dt/3 Q) F' + dt/3 Q + dt/6 (F Q + Q F'), delta into F delta.

    That is Simpson's rule, multiplied out. F (n, d) has the rows of a unit matrix below it.
    """
    d = F.shape[1]
    for a in range(d):
        add(P[a, a], dt / 3.0, Q[a])
    for a in range(n):
        row[a, :] = 0.0
        for b in range(d):
            FP[a, b, :] = 0.0
        for c in range(d):
            if F[a, c] != 0.0:
                add(row[a], F[a, c], delta[c])
                for b in range(d):
                    add(FP[a, b], F[a, c], P[c, b])
    for a in range(n):
        delta[a, :] = row[a]
        for b in range(a + 1):
            P[a, b, :] = 0.0
            for c in range(d):
                if F[b, c] != 0.0:
                    add(P[a, b], F[b, c], FP[a, c])
        for b in range(n, d):
            P[b, a, :] = FP[a, b]
    for a in range(d):
        add(P[a, a], dt / 3.0 if a < n else 2.0 / 3.0 * dt, Q[a])
        for b in range(n):
            if F[b, a] != 0.0:
                add(P[max(a, b), min(a, b)], dt / 6.0 * F[b, a] * (2.0 if a == b else 1.0), Q[a])
    for a in range(d):
        for b in range(a):
            P[b, a, :] = P[a, b]


@accelerated
def update(C: Array, P: Array, PC: Array, delta: Array, e: Array, S: Array) -> None:
    """Correct P and delta by one output with derivatives C (d,).

    e and S (L,), residual and noise at first, become innovation and variance.
    """
    d = C.size
    for a in range(d):
        PC[a, :] = 0.0
        for b in range(d):
            if C[b] != 0.0:
                add(PC[a], C[b], P[a, b])
        if C[a] != 0.0:
            add(S, C[a], PC[a])
            add(e, -C[a], delta[a])
    for a in range(d):
        for lane in range(LANES):
            gain = PC[a, lane] / S[lane]
            delta[a, lane] += gain * e[lane]
            for b in range(a + 1):
                P[a, b, lane] -= gain * PC[b, lane]
        for b in range(a):
            P[b, a, :] = P[a, b]


@accelerated
def add(total: Array, factor: float, row: Array) -> None:
    """Add a multiple of one row of lanes to another."""
    for lane in range(LANES):
        total[lane] += factor * row[lane]


likelihoods = accelerated(_likelihoods_in_loops, _likelihoods_on_arrays)
