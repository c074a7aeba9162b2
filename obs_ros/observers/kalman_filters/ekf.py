"""The extended Kalman filter on states and parameters together.

The model is linearised along the way by central differences: the mean and two perturbed candidates
for each of the D joint states are carried in one go, which costs no more than the mean alone.
"""

import math
from typing import Any

import numpy as np

from obs_ros.core.jit import accelerated
from obs_ros.core.model import Model
from obs_ros.core.typing import Array, IntArray
from obs_ros.observers.kalman_filters.joint import KalmanObserver, clip, limit, place, report, root

DIFFERENCE = 6e-6  # of the box: the cube root of the floats' resolution


class ExtendedKalmanObserver(KalmanObserver):
    """Extended Kalman filter; see `KalmanObserver`.

    With F and H the derivatives of step and output at the mean, Q and R the covariances of walk
    and noise:

        C <- F C F' + Q;   K = C H' / (H C H' + R);   z <- z + K (y - h(z));
        C <- (I - K H) C (I - K H)' + K R K'

    the last three, Joseph's form, for one output after the other.
    """

    def __init__(self, model: Model | str, **arguments: Any) -> None:
        super().__init__(model, **arguments)
        self._differences = DIFFERENCE * self._width
        self._gaps = np.empty(self.z.size)

    def _spread(self) -> None:
        spread(self.z, self._differences, self._low, self._high, self._rows, self._x, self._p,
               self._gaps)  # fmt: skip

    def _predict(self, interval: float) -> bool:
        predict(
            self.z, self.covariance, interval, self._walk, self._differences, self._low,
            self._high, self._rows, self._x, self._p, self._gaps,
        )  # fmt: skip
        return True  # F C F' + Q is one if C was, and _update looks again

    def _update(self, y: Array) -> bool:
        return update(
            self.z, self.covariance, y, self._noise, self._y, self._most, self._differences,
            self._low, self._high, self._rows, self._x, self._p, self._gaps,
            self.innovation, self._surprise, self.x, self.p, self.stddev,
        )  # fmt: skip


@accelerated
def spread(
    z: Array, step: Array, low: Array, high: Array, rows: IntArray, x: Array, p: Array, gaps: Array
) -> None:
    """Lay out z in lane 0 and wherever no other is, and z_i +- step_i, within bounds, in two more.

    gaps (D,) are the distances of the two.
    """
    for lane in range(x.shape[1]):
        place(z, lane, rows, x, p)
    n = x.shape[0]
    for i in range(z.size):
        reach = max(step[i], 1e-10 * abs(z[i]))
        above, below = min(z[i] + reach, high[i]), max(z[i] - reach, low[i])
        gaps[i] = above - below
        if i < n:
            x[i, 1 + 2 * i], x[i, 2 + 2 * i] = above, below
        else:
            p[rows[i - n], 1 + 2 * i], p[rows[i - n], 2 + 2 * i] = above, below


@accelerated
def predict(
    z: Array, c: Array, interval: float, walk: Array, step: Array, low: Array, high: Array,
    rows: IntArray, x: Array, p: Array, gaps: Array,
) -> None:  # fmt: skip
    """Take mean and covariance from the carried candidates."""
    d, n = z.size, x.shape[0]
    f = np.zeros((d, d))
    for i in range(n):
        z[i] = x[i, 0]
        for j in range(d):
            f[i, j] = (x[i, 1 + 2 * j] - x[i, 2 + 2 * j]) / gaps[j]
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
    clip(z, low, high)
    spread(z, step, low, high, rows, x, p, gaps)


@accelerated
def update(
    z: Array, c: Array, y: Array, noise: Array, yhat: Array, most: Array, step: Array, low: Array,
    high: Array, rows: IntArray, xs: Array, ps: Array, gaps: Array,
    innovation: Array, surprise: Array, x: Array, p: Array, stddev: Array,
) -> bool:  # fmt: skip
    """Correct by one output after the other; False if no covariance is left."""
    d = z.size
    h, ch, gain, shift = np.empty(d), np.empty(d), np.empty(d), np.zeros(d)
    surprise[0], measured = 0.0, 0
    for i in range(y.size):
        innovation[i] = y[i] - yhat[i, 0]
        if math.isnan(y[i]):
            continue
        error, s = innovation[i], noise[i]
        for j in range(d):
            h[j] = (yhat[i, 1 + 2 * j] - yhat[i, 2 + 2 * j]) / gaps[j]
            error -= h[j] * shift[j]  # the earlier outputs have moved the mean by that
        for j in range(d):
            ch[j] = 0.0
            for k in range(d):
                ch[j] += c[j, k] * h[k]
            s += h[j] * ch[j]
        surprise[0] += error * error / s
        measured += 1
        for j in range(d):
            gain[j] = ch[j] / s
            shift[j] += gain[j] * error
        joseph(c, h, ch, gain, noise[i])
    surprise[0] /= max(measured, 1)
    for j in range(d):
        z[j] += shift[j]
    clip(z, low, high)
    limit(c, most)
    report(z, c, rows, x, p, stddev)
    spread(z, step, low, high, rows, xs, ps, gaps)
    return root(c, np.empty((d, d)))


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
