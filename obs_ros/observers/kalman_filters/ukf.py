"""The unscented Kalman filter on states and parameters together.

No derivatives: 2 D + 1 sigma points are propagated, and mean and covariance taken from them.
"""

import math
from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import numpy as np

from obs_ros.core.jit import accelerated
from obs_ros.core.periods import shortest_way
from obs_ros.core.typing import Array
from obs_ros.inference.innovation_gate import REJECTED, REOPENED, judged
from obs_ros.observers import settings as table
from obs_ros.observers.kalman_filters.deviations import KalmanSettings
from obs_ros.observers.kalman_filters.joint import (
    Joint,
    KalmanObserver,
    Kernels,
    clip,
    limit,
    place,
    report,
    root,
    widening,
)
from obs_ros.observers.settings import setting


class Workspace(NamedTuple):
    """The joint state, and the sigma points about it."""

    joint: Joint
    weights: Array  # (4,) of the central point in means and in covariances, of each other; reach
    points: Array  # (D, 2 D + 1) the points themselves, which may lie beyond the bounds


@dataclass(frozen=True)
class UnscentedSettings(KalmanSettings):
    """Spread of the sigma points, besides: sqrt(alpha^2 (D + kappa)) standard deviations."""

    alpha: float = setting(1.0, 'spread of the sigma points', lower=1e-4, upper=10.0)
    beta: float = setting(
        2.0, 'weight of the mean in the covariance; 2 for normal distributions', lower=0.0,
        upper=1e3,
    )  # fmt: skip
    kappa: float = setting(0.0, 'secondary spread of the sigma points', lower=0.0, upper=1e3)


class UnscentedKalmanObserver(KalmanObserver):
    """Unscented Kalman filter (Julier & Uhlmann 2004) on the model of `KalmanObserver`.

        z' = f(z, u) + w,  w ~ N(0, Q);   y = h(z, u) + v,  v ~ N(0, R)

    With lambda = alpha^2 (D + kappa) - D the mean weighs lambda / (D + lambda), in covariances
    1 - alpha^2 + beta more, and the points z +- sqrt(D + lambda) column of the root of C weigh
    1 / (2 (D + lambda)) each. The model sees a point clipped to the bounds. Innovations of outputs
    with a period go the shortest way; such outputs must be continuous functions of the state, as
    points may be more than half a period apart.
    """

    Settings: ClassVar[type[table.Settings]] = UnscentedSettings

    def _workspace(self) -> Workspace:
        s, d = self.settings, self.joint.z.size
        scale = s.alpha**2 * (d + s.kappa)  # D + lambda
        mean = 1.0 - d / scale
        central = mean + 1.0 - s.alpha**2 + s.beta
        weights = np.array([mean, central, 0.5 / scale, math.sqrt(scale)])
        return Workspace(self.joint, weights, np.empty((d, 2 * d + 1)))

    def _kernels(self) -> Kernels:
        return Kernels(draw, predict, update)


@accelerated
def draw(kf: Workspace) -> bool:
    """Write the sigma points, and those that the model sees; False if C has no root."""
    points, reach, z, rows = kf.points, kf.weights[3], kf.joint.z, kf.joint.rows
    low, high, xs, ps = kf.joint.low, kf.joint.high, kf.joint.xs, kf.joint.ps
    d = z.size
    lower = np.empty((d, d))
    good = root(kf.joint.covariance, lower)
    seen = np.empty(d)
    for lane in range(xs.shape[1]):
        column = (lane - 1) // 2
        for i in range(d):
            seen[i] = z[i]
            if good and 0 < lane <= 2 * d:
                offset = reach * lower[i, column]
                seen[i] += offset if lane % 2 else -offset
            if lane <= 2 * d:
                points[i, lane] = seen[i]
        clip(seen, low, high)
        place(seen, lane, rows, xs, ps)
    return good


@accelerated
def predict(kf: Workspace, interval: float) -> bool:
    """Take mean and covariance from the propagated points, and draw new ones if possible."""
    weights, points, walk = kf.weights, kf.points, kf.joint.walk
    z, c, xs = kf.joint.z, kf.joint.covariance, kf.joint.xs
    d, n = z.size, xs.shape[0]
    count = 2 * d + 1
    for i in range(n):
        for lane in range(count):
            points[i, lane] = xs[i, lane]
    for i in range(d):
        total = 0.0
        for lane in range(1, count):
            total += points[i, lane]
        z[i] = weights[0] * points[i, 0] + weights[2] * total
    for i in range(d):
        for j in range(i + 1):
            total = 0.0
            for lane in range(1, count):
                total += (points[i, lane] - z[i]) * (points[j, lane] - z[j])
            middle = weights[1] * (points[i, 0] - z[i]) * (points[j, 0] - z[j])
            c[i, j] = c[j, i] = middle + weights[2] * total
        c[i, i] += walk[i] * interval
    clip(z, kf.joint.low, kf.joint.high)
    return draw(kf)


@accelerated
def update(kf: Workspace, y: Array) -> bool:
    """Correct by all measured outputs at once; False if no covariance is left.

    C <- sum of w (dz - K dy) (dz - K dy)' + K R K', which like Joseph's form stays a covariance.
    """
    weights, points, z, c = kf.weights, kf.points, kf.joint.z, kf.joint.covariance
    ys, noise, innovation = kf.joint.ys, kf.joint.noise, kf.joint.innovation
    period = kf.joint.period
    d, r, count = z.size, y.size, points.shape[1]
    dy = np.zeros((r, count))
    seen, wider = y.copy(), 1.0
    for i in range(r):
        total = 0.0
        for lane in range(1, count):
            total += ys[i, lane]
        mean = weights[0] * ys[i, 0] + weights[2] * total
        innovation[i] = shortest_way(y[i] - mean, period[i])
        if not math.isnan(y[i]):
            for lane in range(count):
                dy[i, lane] = ys[i, lane] - mean
        spread_of_y = covariance_of(dy[i], dy[i], weights)
        kf.joint.innovation_stddev[i] = math.nan
        if not math.isnan(y[i]):
            deviation = math.sqrt(max(noise[i] + spread_of_y, 0.0))
            kf.joint.innovation_stddev[i] = deviation
            verdict = judged(kf.joint.gate, i, abs(innovation[i]) / deviation)
            if verdict == REJECTED:
                seen[i] = math.nan
                dy[i] = 0.0
            elif verdict == REOPENED:
                wider = max(wider, widening(innovation[i], noise[i], spread_of_y))
    dz = np.empty((d, count))
    for i in range(d):
        for lane in range(count):
            dz[i, lane] = points[i, lane] - z[i]
    if wider > 1.0 and wider < math.inf:  # as if the points lay further out
        dz *= math.sqrt(wider)
        dy *= math.sqrt(wider)
    gain = np.zeros((d, r))
    good = gains(kf, seen, dz, dy, gain)
    for i in range(d if good else 0):
        for k in range(r):
            if not math.isnan(seen[k]):
                z[i] += gain[i, k] * innovation[k]
                for lane in range(count):
                    dz[i, lane] -= gain[i, k] * dy[k, lane]
    for i in range(d):
        for j in range(i + 1):
            total = covariance_of(dz[i], dz[j], weights)
            for k in range(r):
                total += gain[i, k] * noise[k] * gain[j, k]
            c[i, j] = c[j, i] = total
    clip(z, kf.joint.low, kf.joint.high)
    limit(c, kf.joint.most)
    report(kf.joint)
    return draw(kf) and good


@accelerated
def covariance_of(a: Array, b: Array, weights: Array) -> float:
    """Return the covariance of two variables by their deviations (2 D + 1,) from their means."""
    total = 0.0
    for lane in range(1, a.size):
        total += a[lane] * b[lane]
    return float(weights[1] * a[0] * b[0] + weights[2] * total)


@accelerated
def gains(kf: Workspace, seen: Array, dz: Array, dy: Array, gain: Array) -> bool:
    """Write K (D, r) = C_zy / (C_yy + R) over zeros; 0 where dy is, for outputs not `seen`, NaN.

    False, with K as it was, where C_yy + R is no covariance. The mean of the squared innovations in
    units of that becomes the surprise.
    """
    noise, weights, innovation = kf.joint.noise, kf.weights, kf.joint.innovation
    surprise = kf.joint.surprise
    d, r = dz.shape[0], dy.shape[0]
    s = np.empty((r, r))
    for k in range(r):
        for m in range(r):
            s[k, m] = covariance_of(dy[k], dy[m], weights)
        s[k, k] += noise[k]
    lower = np.empty((r, r))
    surprise[0] = 0.0
    if not root(s, lower):
        return False
    scaled, measured = np.zeros(r), 0
    for k in range(r):
        if not math.isnan(seen[k]):
            scaled[k] = innovation[k]
            for m in range(k):
                scaled[k] -= lower[k, m] * scaled[m]
            scaled[k] /= lower[k, k]
            surprise[0] += scaled[k] * scaled[k]
            measured += 1
    surprise[0] /= max(measured, 1)
    for i in range(d):
        for k in range(r):
            gain[i, k] = covariance_of(dz[i], dy[k], weights)
        for k in range(r):
            for m in range(k):
                gain[i, k] -= lower[k, m] * gain[i, m]
            gain[i, k] /= lower[k, k]
        for k in range(r - 1, -1, -1):
            for m in range(k + 1, r):
                gain[i, k] -= lower[m, k] * gain[i, m]
            gain[i, k] /= lower[k, k]
    return True
