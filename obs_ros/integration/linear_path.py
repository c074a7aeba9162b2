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


Sizes = tuple[int, ...]  # only its length counts, which Numba knows when it compiles


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
        out = np.empty(lanes(count))
        with np.errstate(all='ignore'):
            for variances, deviations in ((Q, walks[found.index]), (R, noise)):
                variances[:, :count] = deviations**2
                variances[:, count:] = variances[:, count - 1 : count]
            likelihoods(
                found.dt, found.transition, found.sensitivity, found.measured, self.residuals,
                self.corrections, found.prior, Q, R, out, (0,) * found.transition.shape[1],
                (0,) * found.index.size,
            )  # fmt: skip
        return np.where(np.isfinite(out), out, np.inf)[:count]


def _likelihoods_on_arrays(
    dt: Array, transition: Array, sensitivity: Array, measured: BoolArray, residuals: Array,
    corrections: Array, prior: Array, Q: Array, R: Array, out: Array, states: Sizes, joint: Sizes,
) -> None:  # fmt: skip
    """Compute the likelihoods with one matrix for each set of noise."""
    n, d = len(states), len(joint)
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
    corrections: Array, prior: Array, Q: Array, R: Array, out: Array, states: Sizes, joint: Sizes,
) -> None:  # fmt: skip
    """Compute the likelihoods of a chunk at a time, its lanes innermost.

    One array w holds all rows of lanes, so that the compiler sees which of them overlap: P (d, d),
    F P (n, d), delta (d,), F delta or P C' (d,), Q (d,), e, S, the product of S, the total.
    """
    d = len(joint)
    delta, noise = 2 * d * d, 2 * d * d + 2 * d
    e, S, product, total = noise + d, noise + d + 1, noise + d + 2, noise + d + 3
    w = np.empty((total + 1) * LANES)
    rows = w.reshape((total + 1, LANES))
    for first in range(0, out.size, LANES):
        rows[noise : noise + d] = Q[:, first : first + LANES]
        rows[delta : delta + d], rows[product], rows[total], factors = 0.0, 1.0, 0.0, 0
        for a in range(d):
            for b in range(d):
                rows[a * d + b] = prior[a, b]
        for k in range(len(measured)):
            if k > 0:
                predict(w, transition[k - 1], dt[k - 1], states, joint)
            for i in range(measured.shape[1]):
                if measured[k, i]:
                    for lane in range(LANES):
                        w[e * LANES + lane] = residuals[k, i]
                        w[S * LANES + lane] = R[i, first + lane]
                    update(w, sensitivity[k, i], joint)
                    factors += 1
                    if factors % 8 == 0:  # a logarithm costs more than all the rest
                        rows[total] += np.log(rows[product])
                        rows[product] = 1.0
            for a in range(d):
                for lane in range(LANES):
                    w[(delta + a) * LANES + lane] -= corrections[k, a]
        out[first : first + LANES] = rows[total] + np.log(rows[product])


@accelerated
def predict(w: Array, F: Array, dt: float, states: Sizes, joint: Sizes) -> None:
    """Turn P into F (P + dt/3 Q) F' + dt/3 Q + dt/6 (F Q + Q F'), delta into F delta.

    That is Simpson's rule, multiplied out. F (n, d) has the rows of a unit matrix below it.
    """
    n, d = len(states), len(joint)
    FP, delta, moved, Q = d * d, 2 * d * d, 2 * d * d + d, 2 * d * d + 2 * d
    for a in range(d):
        add(w, a * d + a, dt / 3.0, Q + a)
    for a in range(n):
        put(w, moved + a, F[a, 0], delta)
        for b in range(d):
            put(w, FP + a * d + b, F[a, 0], b)
        for c in range(1, d):
            add(w, moved + a, F[a, c], delta + c)
            for b in range(d):
                add(w, FP + a * d + b, F[a, c], c * d + b)
    for a in range(n):
        put(w, delta + a, 1.0, moved + a)
        for b in range(a + 1):
            put(w, a * d + b, F[b, 0], FP + a * d)
            for c in range(1, d):
                add(w, a * d + b, F[b, c], FP + a * d + c)
        for b in range(n, d):
            put(w, b * d + a, 1.0, FP + a * d + b)
    for a in range(d):
        add(w, a * d + a, dt / 3.0 if a < n else 2.0 / 3.0 * dt, Q + a)
        for b in range(n):
            factor = dt / 6.0 * F[b, a]
            add(w, max(a, b) * d + min(a, b), 2.0 * factor if a == b else factor, Q + a)
    for a in range(d):
        for b in range(a):
            put(w, b * d + a, 1.0, a * d + b)


@accelerated
def update(w: Array, C: Array, joint: Sizes) -> None:
    """Correct P and delta by one output with derivatives C (d,), and count it.

    e and S, residual and noise at first, become innovation and variance.
    """
    d = len(joint)
    delta, PC, e = 2 * d * d, 2 * d * d + d, 2 * d * d + 3 * d
    S, product, total = e + 1, e + 2, e + 3
    for a in range(d):
        put(w, PC + a, C[0], a * d)
        for b in range(1, d):
            add(w, PC + a, C[b], a * d + b)
        add(w, S, C[a], PC + a)
        add(w, e, -C[a], delta + a)
    for lane in range(LANES):
        w[product * LANES + lane] *= w[S * LANES + lane]
        w[S * LANES + lane] = 1.0 / w[S * LANES + lane]
        w[total * LANES + lane] += w[e * LANES + lane] ** 2 * w[S * LANES + lane]
    for a in range(d):
        for lane in range(LANES):
            gain = w[(PC + a) * LANES + lane] * w[S * LANES + lane]
            w[(delta + a) * LANES + lane] += gain * w[e * LANES + lane]
            for b in range(a + 1):
                w[(a * d + b) * LANES + lane] -= gain * w[(PC + b) * LANES + lane]
        for b in range(a):
            put(w, b * d + a, 1.0, a * d + b)


@accelerated
def put(w: Array, to: int, factor: float, row: int) -> None:
    """Write a multiple of one row of lanes into another."""
    for lane in range(LANES):
        w[to * LANES + lane] = factor * w[row * LANES + lane]


@accelerated
def add(w: Array, to: int, factor: float, row: int) -> None:
    """Add a multiple of one row of lanes to another."""
    for lane in range(LANES):
        w[to * LANES + lane] += factor * w[row * LANES + lane]


likelihoods = accelerated(_likelihoods_in_loops, _likelihoods_on_arrays)
