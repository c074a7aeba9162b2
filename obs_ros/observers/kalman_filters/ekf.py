"""The extended Kalman filter on states and parameters together.

The model is linearised along the way by central differences: the mean and two perturbed candidates
for each of the D joint states are propagated in one go, which costs no more than the mean alone.
"""

import math
from typing import NamedTuple

import numpy as np

from obs_ros.core.jit import accelerated
from obs_ros.core.periods import shortest_way
from obs_ros.core.typing import Array
from obs_ros.inference.innovation_gate import REJECTED, REOPENED, judged
from obs_ros.observers.kalman_filters.joint import (
    Joint,
    KalmanObserver,
    Kernels,
    clip,
    limit,
    place,
    report,
    root,
    widen,
    widening,
)


class Workspace(NamedTuple):
    """The joint state, and the differences that linearise the model about it."""

    joint: Joint
    steps: Array  # (D,) wanted distances of the perturbed candidates from the mean
    gaps: Array  # (D,) distances of the two of each pair, which bounds may shorten


class ExtendedKalmanObserver(KalmanObserver):
    """Extended Kalman filter (Jazwinski 1970, section 8.3) on the model of `KalmanObserver`.

        z' = f(z, u) + w,  w ~ N(0, Q);   y = h(z, u) + v,  v ~ N(0, R)

    With F and H the derivatives of step and output at the mean, dt s apart:

        z <- f(z);   C <- F C F' + Q dt
        K = C H' / (H C H' + R);   z <- z + K (y - h(z));
        C <- (I - K H) C (I - K H)' + K R K'

    the last line, Joseph's form, and the one before for one output after the other. An output that
    the gate rejects corrects nothing.
    """

    def _workspace(self) -> Workspace:
        return Workspace(self.joint, self.difference * self._width, np.empty(self.joint.z.size))

    def _kernels(self) -> Kernels:
        return Kernels(spread, predict, update)


@accelerated
def spread(kf: Workspace) -> bool:
    """Lay out z in lane 0 and wherever no other is, and z_i +- a step, in bounds, in two more."""
    steps, gaps, z, rows = kf.steps, kf.gaps, kf.joint.z, kf.joint.rows
    low, high, xs, ps = kf.joint.low, kf.joint.high, kf.joint.xs, kf.joint.ps
    n = xs.shape[0]
    for lane in range(xs.shape[1]):
        place(z, lane, rows, xs, ps)
    for i in range(z.size):
        reach = max(steps[i], 1e-10 * abs(z[i]))
        above, below = min(z[i] + reach, high[i]), max(z[i] - reach, low[i])
        gaps[i] = above - below
        if i < n:
            xs[i, 1 + 2 * i], xs[i, 2 + 2 * i] = above, below
        else:
            ps[rows[i - n], 1 + 2 * i], ps[rows[i - n], 2 + 2 * i] = above, below
    return True


@accelerated
def predict(kf: Workspace, interval: float) -> bool:
    """Take mean and covariance from the propagated candidates: F C F' + Q is one if C was."""
    gaps, walk, z, c, xs = kf.gaps, kf.joint.walk, kf.joint.z, kf.joint.covariance, kf.joint.xs
    d, n = z.size, xs.shape[0]
    f = np.zeros((d, d))
    for i in range(n):
        z[i] = xs[i, 0]
        for j in range(d):
            f[i, j] = (xs[i, 1 + 2 * j] - xs[i, 2 + 2 * j]) / gaps[j]
    for i in range(n, d):
        f[i, i] = 1.0
    fc = np.zeros((d, d))
    for i in range(d):
        for k in range(d):
            if f[i, k] != 0.0:
                for j in range(d):
                    fc[i, j] += f[i, k] * c[k, j]
    for i in range(d):
        for j in range(i + 1):
            total = 0.0
            for k in range(d):
                total += fc[i, k] * f[j, k]
            c[i, j] = c[j, i] = total
        c[i, i] += walk[i] * interval
    clip(z, kf.joint.low, kf.joint.high)
    return spread(kf)


@accelerated
def update(kf: Workspace, y: Array) -> bool:
    """Correct by one output after the other; False if no covariance is left."""
    gaps, z, c, ys = kf.gaps, kf.joint.z, kf.joint.covariance, kf.joint.ys
    noise, innovation, period = kf.joint.noise, kf.joint.innovation, kf.joint.period
    d = z.size
    h, ch, gain, shift = np.empty(d), np.empty(d), np.empty(d), np.zeros(d)
    surprise, measured = 0.0, 0
    passed, wider = np.zeros(y.size, np.bool_), 1.0
    for i in range(y.size):
        innovation[i] = shortest_way(y[i] - ys[i, 0], period[i])
        kf.joint.innovation_stddev[i] = math.nan
        if not math.isnan(y[i]):
            differentiate(ys[i], gaps, period[i], h)
            spread_of_y = spread_along(h, c, ch)
            deviation = math.sqrt(max(noise[i] + spread_of_y, 0.0))
            kf.joint.innovation_stddev[i] = deviation
            verdict = judged(kf.joint.gate, i, abs(innovation[i]) / deviation)
            passed[i] = verdict != REJECTED
            if verdict == REOPENED:
                wider = max(wider, widening(innovation[i], noise[i], spread_of_y))
    widen(c, wider, kf.joint.most)
    for i in range(y.size):
        if not passed[i]:
            continue
        error = innovation[i]
        differentiate(ys[i], gaps, period[i], h)
        for j in range(d):
            error -= h[j] * shift[j]  # the earlier outputs have moved the mean by that
        s = noise[i] + spread_along(h, c, ch)
        surprise += error * error / s
        measured += 1
        for j in range(d):
            gain[j] = ch[j] / s
            shift[j] += gain[j] * error
        joseph(c, h, ch, gain, noise[i])
    kf.joint.surprise[0] = surprise / max(measured, 1)
    for j in range(d):
        z[j] += shift[j]
    clip(z, kf.joint.low, kf.joint.high)
    limit(c, kf.joint.most)
    report(kf.joint)
    spread(kf)
    return root(c, np.empty((d, d)))


@accelerated
def differentiate(values: Array, gaps: Array, period: float, h: Array) -> None:
    """Write the derivatives h (D,) of a value of which all candidates' are given."""
    for j in range(h.size):
        h[j] = shortest_way(values[1 + 2 * j] - values[2 + 2 * j], period) / gaps[j]


@accelerated
def spread_along(h: Array, c: Array, ch: Array) -> float:
    """Write C h into ch (D,); return h C h'."""
    total = 0.0
    for j in range(h.size):
        ch[j] = 0.0
        for k in range(h.size):
            ch[j] += c[j, k] * h[k]
        total += h[j] * ch[j]
    return total


@accelerated
def joseph(c: Array, h: Array, ch: Array, gain: Array, noise: float) -> None:
    """Turn C into (I - K h) C (I - K h)' + K R K', with C h given, and keep it symmetric."""
    d = h.size
    mh = np.zeros(d)
    for i in range(d):
        for j in range(d):
            c[i, j] -= gain[i] * ch[j]
            mh[i] += c[i, j] * h[j]
    for i in range(d):
        for j in range(d):
            c[i, j] += (noise * gain[i] - mh[i]) * gain[j]
    for i in range(d):
        for j in range(i):
            c[i, j] = c[j, i] = 0.5 * (c[i, j] + c[j, i])
