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

COUNT = np.uint64(LANES)  # loops over an unsigned range are vectorised, others unrolled

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
                (0,) * found.index.size, found.discrete,
            )  # fmt: skip
        return np.where(np.isfinite(out), out, np.inf)[:count]


def _likelihoods_on_arrays(
    dt: Array, transition: Array, sensitivity: Array, measured: BoolArray, residuals: Array,
    corrections: Array, prior: Array, Q: Array, R: Array, out: Array, states: Sizes, joint: Sizes,
    discrete: bool,
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
            if discrete:
                noises = 6.0 * spread
            else:
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
    discrete: bool,
) -> None:  # fmt: skip
    """Compute the likelihoods of a chunk at a time, its lanes innermost.

    One array w holds all rows of lanes, so that the compiler sees which of them overlap: P (d, d),
    F P (n, d), delta (d,), F delta or P C' (d,), Q (d,), the product of S, the sum.
    """
    # Number by number: assigning arrays compiles a message on their shapes, for seconds.
    d = len(joint)
    delta, walk = 2 * d * d, 2 * d * d + 2 * d
    product, total = walk + d, walk + d + 1
    w = np.empty((total + 1) * LANES)
    rows = w.reshape((total + 1, LANES))
    for first in range(0, out.size, LANES):
        factors = 0
        for lane in range(LANES):
            rows[product, lane], rows[total, lane] = 1.0, 0.0
            for a in range(d):
                rows[walk + a, lane], rows[delta + a, lane] = Q[a, first + lane], 0.0
                for b in range(d):
                    rows[a * d + b, lane] = prior[a, b]
        for k in range(len(measured)):
            if k > 0:
                predict(w, transition[k - 1], dt[k - 1], states, joint, discrete)
            for i in range(measured.shape[1]):
                if measured[k, i]:
                    noise = R[i, first : first + LANES]
                    update(w, sensitivity[k, i], residuals[k, i], noise, joint)
                    factors += 1
                    if factors % 8 == 0:  # a logarithm costs more than all the rest
                        for lane in range(LANES):
                            rows[total, lane] += np.log(rows[product, lane])
                            rows[product, lane] = 1.0
            for a in range(d):
                for lane in range(COUNT):
                    w[np.uint64(delta + a) * COUNT + lane] -= corrections[k, a]
        for lane in range(LANES):
            out[first + lane] = rows[total, lane] + np.log(rows[product, lane])


@accelerated
def predict(w: Array, F: Array, dt: float, states: Sizes, joint: Sizes, discrete: bool) -> None:
    """Turn P into F (P + dt/3 Q) F' + dt/3 Q + dt/6 (F Q + Q F'), delta into F delta.

    That is Simpson's rule, multiplied out; of a discrete model P becomes F P F' + dt Q. F (n, d)
    has the rows of a unit matrix below it.
    """
    first, last, all_later, across = dt / 3.0, dt / 3.0, 2.0 / 3.0 * dt, dt / 6.0
    if discrete:
        first, last, all_later, across = 0.0, dt, dt, 0.0
    n, d = len(states), len(joint)
    FP, delta, moved, Q = d * d, 2 * d * d, 2 * d * d + d, 2 * d * d + 2 * d
    for lane in range(COUNT):
        for a in range(d):
            w[np.uint64(a * d + a) * COUNT + lane] += first * w[np.uint64(Q + a) * COUNT + lane]
    for a in range(n):
        for lane in range(COUNT):
            for b in range(d):
                sum_c = 0.0
                for c in range(d):
                    sum_c += F[a, c] * w[np.uint64(c * d + b) * COUNT + lane]
                w[np.uint64(FP + a * d + b) * COUNT + lane] = sum_c
            sum_c = 0.0
            for c in range(d):
                sum_c += F[a, c] * w[np.uint64(delta + c) * COUNT + lane]
            w[np.uint64(moved + a) * COUNT + lane] = sum_c
    for a in range(n):
        for lane in range(COUNT):
            w[np.uint64(delta + a) * COUNT + lane] = w[np.uint64(moved + a) * COUNT + lane]
            for b in range(a + 1):
                sum_c = across * F[a, b] * w[np.uint64(Q + b) * COUNT + lane]
                sum_c += across * F[b, a] * w[np.uint64(Q + a) * COUNT + lane]
                for c in range(d):
                    sum_c += F[b, c] * w[np.uint64(FP + a * d + c) * COUNT + lane]
                w[np.uint64(a * d + b) * COUNT + lane] = sum_c
                w[np.uint64(b * d + a) * COUNT + lane] = sum_c
            for b in range(n, d):
                value = w[np.uint64(FP + a * d + b) * COUNT + lane]
                value += across * F[a, b] * w[np.uint64(Q + b) * COUNT + lane]
                w[np.uint64(a * d + b) * COUNT + lane] = value
                w[np.uint64(b * d + a) * COUNT + lane] = value
    for lane in range(COUNT):
        for a in range(d):
            share = last if a < n else all_later
            w[np.uint64(a * d + a) * COUNT + lane] += share * w[np.uint64(Q + a) * COUNT + lane]


@accelerated
def update(w: Array, C: Array, residual: float, noise: Array, joint: Sizes) -> None:
    """Correct P and delta by one output with derivatives C (d,), and count it."""
    d = len(joint)
    delta, PC = 2 * d * d, 2 * d * d + d
    product, total = np.uint64(2 * d * d + 3 * d), np.uint64(2 * d * d + 3 * d + 1)
    for lane in range(COUNT):
        error, S = residual, noise[lane]
        for a in range(d):
            sum_b = 0.0
            for b in range(d):
                sum_b += C[b] * w[np.uint64(a * d + b) * COUNT + lane]
            w[np.uint64(PC + a) * COUNT + lane] = sum_b
            S += C[a] * sum_b
            error -= C[a] * w[np.uint64(delta + a) * COUNT + lane]
        inverse = 1.0 / S
        w[product * COUNT + lane] *= S
        w[total * COUNT + lane] += error * error * inverse
        for a in range(d):
            gain = w[np.uint64(PC + a) * COUNT + lane] * inverse
            w[np.uint64(delta + a) * COUNT + lane] += gain * error
            for b in range(a + 1):
                value = w[np.uint64(a * d + b) * COUNT + lane]
                value -= gain * w[np.uint64(PC + b) * COUNT + lane]
                w[np.uint64(a * d + b) * COUNT + lane] = value
                w[np.uint64(b * d + a) * COUNT + lane] = value


likelihoods = accelerated(_likelihoods_in_loops, _likelihoods_on_arrays)
