"""The unscented Kalman filter on states and parameters together.

No derivatives: 2 D + 1 sigma points are carried, and mean and covariance taken from them.
"""

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from obs_ros.core.jit import accelerated
from obs_ros.core.model import Model
from obs_ros.core.typing import Array, IntArray
from obs_ros.observers import settings as table
from obs_ros.observers.kalman_filters.joint import (
    KalmanObserver,
    KalmanSettings,
    clip,
    limit,
    place,
    report,
    root,
)
from obs_ros.observers.settings import setting


@dataclass(frozen=True)
class UnscentedSettings(KalmanSettings):
    """What spreads the sigma points, besides: sqrt(alpha^2 (D + kappa)) standard deviations."""

    alpha: float = setting(1.0, 'spread of the sigma points', lower=1e-4, upper=10.0)
    beta: float = setting(
        2.0,
        'weight of the mean in the covariance; 2 for normal distributions',
        lower=0.0,
        upper=1e3,
    )
    kappa: float = setting(0.0, 'secondary spread of the sigma points', lower=0.0, upper=1e3)


class UnscentedKalmanObserver(KalmanObserver):
    """Unscented Kalman filter; see `KalmanObserver`.

    With lambda = alpha^2 (D + kappa) - D the mean weighs lambda / (D + lambda), in covariances
    1 - alpha^2 + beta more, and the points z +- sqrt(D + lambda) column of the root of C weigh
    1 / (2 (D + lambda)) each. What the model gets to see of a point is clipped to the bounds.
    """

    Settings: ClassVar[type[table.Settings]] = UnscentedSettings

    def __init__(self, model: Model | str, **arguments: Any) -> None:
        super().__init__(model, **arguments)
        s, d = self.settings, self.z.size
        scale = s.alpha**2 * (d + s.kappa)  # D + lambda
        mean = 1.0 - d / scale
        # Of the central point in means, the same in covariances, of each other one; the reach.
        self._weights = np.array(
            [mean, mean + 1.0 - s.alpha**2 + s.beta, 0.5 / scale, math.sqrt(scale)]
        )
        self._points = np.empty((d, 2 * d + 1))

    def _spread(self) -> None:
        draw(self.z, self.covariance, self._weights, self._low, self._high, self._rows,
             self._points, self._x, self._p)  # fmt: skip

    def _predict(self, interval: float) -> bool:
        return predict(
            self.z, self.covariance, interval, self._walk, self._weights, self._low, self._high,
            self._rows, self._points, self._x, self._p,
        )  # fmt: skip

    def _update(self, y: Array) -> bool:
        return update(
            self.z, self.covariance, y, self._noise, self._y, self._most, self._weights,
            self._low, self._high, self._rows, self._points, self._x, self._p,
            self.innovation, self._surprise, self.x, self.p, self.stddev,
        )  # fmt: skip


@accelerated
def draw(
    z: Array, c: Array, weights: Array, low: Array, high: Array, rows: IntArray, points: Array,
    x: Array, p: Array,
) -> bool:  # fmt: skip
    """Write sigma points (D, 2 D + 1), and what the model sees of them; False if C has no root."""
    d = z.size
    lower = np.empty((d, d))
    good = root(c, lower)
    seen = np.empty(d)
    for lane in range(x.shape[1]):
        column = (lane - 1) // 2
        for i in range(d):
            seen[i] = z[i]
            if good and 0 < lane <= 2 * d:
                offset = weights[3] * lower[i, column]
                seen[i] += offset if lane % 2 else -offset
            if lane <= 2 * d:
                points[i, lane] = seen[i]
        clip(seen, low, high)
        place(seen, lane, rows, x, p)
    return good


@accelerated
def predict(
    z: Array, c: Array, interval: float, walk: Array, weights: Array, low: Array, high: Array,
    rows: IntArray, points: Array, x: Array, p: Array,
) -> bool:  # fmt: skip
    """Take mean and covariance from the carried sigma points, and draw new ones if possible."""
    d, n = z.size, x.shape[0]
    count = 2 * d + 1
    for i in range(n):
        for lane in range(count):
            points[i, lane] = x[i, lane]
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
    clip(z, low, high)
    return draw(z, c, weights, low, high, rows, points, x, p)


@accelerated
def update(
    z: Array, c: Array, y: Array, noise: Array, yhat: Array, most: Array, weights: Array,
    low: Array, high: Array, rows: IntArray, points: Array, xs: Array, ps: Array,
    innovation: Array, surprise: Array, x: Array, p: Array, stddev: Array,
) -> bool:  # fmt: skip
    """Correct by all measured outputs at once; False if no covariance is left.

    C <- sum of w (dz - K dy) (dz - K dy)' + K R K', which like Joseph's form stays a covariance.
    """
    d, r, count = z.size, y.size, points.shape[1]
    dy = np.zeros((r, count))
    for i in range(r):
        total = 0.0
        for lane in range(1, count):
            total += yhat[i, lane]
        mean = weights[0] * yhat[i, 0] + weights[2] * total
        innovation[i] = y[i] - mean
        if not math.isnan(y[i]):
            for lane in range(count):
                dy[i, lane] = yhat[i, lane] - mean
    dz = np.empty((d, count))
    for i in range(d):
        for lane in range(count):
            dz[i, lane] = points[i, lane] - z[i]
    gain = np.zeros((d, r))
    good = gains(dz, dy, noise, weights, innovation, surprise, gain)
    for i in range(d if good else 0):
        for k in range(r):
            if not math.isnan(y[k]):
                z[i] += gain[i, k] * innovation[k]
                for lane in range(count):
                    dz[i, lane] -= gain[i, k] * dy[k, lane]
    for i in range(d):
        for j in range(i + 1):
            total = 0.0
            for lane in range(1, count):
                total += dz[i, lane] * dz[j, lane]
            total = weights[1] * dz[i, 0] * dz[j, 0] + weights[2] * total
            for k in range(r):
                total += gain[i, k] * noise[k] * gain[j, k]
            c[i, j] = c[j, i] = total
    clip(z, low, high)
    limit(c, most)
    report(z, c, rows, x, p, stddev)
    return draw(z, c, weights, low, high, rows, points, xs, ps) and good


@accelerated
def gains(
    dz: Array, dy: Array, noise: Array, weights: Array, innovation: Array, surprise: Array,
    gain: Array,
) -> bool:  # fmt: skip
    """Write K (D, r) = C_zy / (C_yy + R) over zeros; 0 where dy is, for outputs not measured.

    False, with K as it was, where C_yy + R is no covariance. surprise (1,) becomes the mean of the
    squared innovations in units of C_yy + R.
    """
    d, r, count = dz.shape[0], dy.shape[0], dy.shape[1]
    s = np.empty((r, r))
    for k in range(r):
        for m in range(r):
            total = 0.0
            for lane in range(1, count):
                total += dy[k, lane] * dy[m, lane]
            s[k, m] = weights[1] * dy[k, 0] * dy[m, 0] + weights[2] * total
        s[k, k] += noise[k]
    lower = np.empty((r, r))
    surprise[0] = 0.0
    if not root(s, lower):
        return False
    scaled, measured = np.zeros(r), 0
    for k in range(r):
        if not math.isnan(innovation[k]):
            scaled[k] = innovation[k]
            for m in range(k):
                scaled[k] -= lower[k, m] * scaled[m]
            scaled[k] /= lower[k, k]
            surprise[0] += scaled[k] * scaled[k]
            measured += 1
    surprise[0] /= max(measured, 1)
    for i in range(d):
        for k in range(r):
            total = 0.0
            for lane in range(1, count):
                total += dz[i, lane] * dy[k, lane]
            gain[i, k] = weights[1] * dz[i, 0] * dy[k, 0] + weights[2] * total
        for k in range(r):
            for m in range(k):
                gain[i, k] -= lower[k, m] * gain[i, m]
            gain[i, k] /= lower[k, k]
        for k in range(r - 1, -1, -1):
            for m in range(k + 1, r):
                gain[i, k] -= lower[m, k] * gain[i, m]
            gain[i, k] /= lower[k, k]
    return True
