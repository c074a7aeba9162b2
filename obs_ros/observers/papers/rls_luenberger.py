"""Recursive least squares on the filtered regression, and a Luenberger observer fed with them."""

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from obs_ros.core.jit import accelerated
from obs_ros.core.typing import Array
from obs_ros.observers import settings as table
from obs_ros.observers.output_intake import Instant
from obs_ros.observers.papers.observer_form import (
    ObserverFormObserver,
    ObserverFormSettings,
    regression_error,
)
from obs_ros.observers.settings import setting


@dataclass(frozen=True)
class RecursiveLeastSquaresSettings(ObserverFormSettings):
    """Those of the least squares, besides."""

    memory: float = setting(
        0.0, 'time constant of forgetting; 0: what was measured once counts for ever', 's',
        lower=0.0, upper=1e9,
    )  # fmt: skip
    covariance: float = setting(
        1e6, 'covariance of the parameters at the start, and at most, in squared noises',
        positive=True, upper=1e18,
    )  # fmt: skip


class RecursiveLeastSquaresObserver(ObserverFormObserver):
    """Solves the regression for theta anew at every sample, by recursive least squares.

    With mu = exp(-interval / memory),

    K = C phi / (mu + phi' C phi);   theta <- theta + K (z - theta' phi);
    C <- (I - K phi') C / mu.

    For plants in observer form of order n, with one input and one output. Standard deviations are
    those of the parameters, for a regression error like the recent ones.
    """

    Settings: ClassVar[type[table.Settings]] = RecursiveLeastSquaresSettings

    def _start(self, now: Instant) -> None:
        super()._start(now)
        self._covariance = self.settings.covariance * np.diag(self._free)
        self._errors = np.zeros(2)  # sums of squared errors and of ones, forgetting

    def _adapt(self, now: Instant, interval: float) -> None:
        memory = self.settings.memory
        keep = math.exp(-interval / memory) if memory else 1.0
        n = self.x.size
        least_squares(
            self._s, self._covariance, now.y, self._filter, keep, self.settings.covariance,
            self._errors, self.stddev,
        )  # fmt: skip
        # Among absurd outputs rounding may leave a sum of squares below zero.
        squares = max(self._errors[0], 0.0)
        self.figures['equation_error'] = math.sqrt(squares / max(1.0, self._errors[1]))
        self.stddev[:n] = math.nan


@accelerated
def least_squares(
    s: Array, c: Array, y: Array, filtr: Array, keep: float, most: float, errors: Array,
    stddev: Array,
) -> None:  # fmt: skip
    """Correct theta in s by one sample; C (2 n, 2 n) stays symmetric, no variance above `most`."""
    n, d = filtr.size, c.shape[0]
    phi, c_phi = np.empty(d), np.zeros(d)
    for i in range(n):
        phi[i], phi[n + i] = s[n + i], -s[2 * n + i]
    error, _ = regression_error(s, y[0], filtr)
    total = keep
    for i in range(d):
        for j in range(d):
            c_phi[i] += c[i, j] * phi[j]
        total += phi[i] * c_phi[i]
    for i in range(d):
        s[3 * n + i] += c_phi[i] / total * error
    for i in range(d):
        for j in range(i + 1):
            c[i, j] = c[j, i] = (c[i, j] - c_phi[i] * c_phi[j] / total) / keep
    for i in range(d):
        if c[i, i] > most:
            factor = math.sqrt(most / c[i, i])
            for j in range(d):
                c[i, j] *= factor
                c[j, i] *= factor
    errors[0] = keep * errors[0] + error * error * keep / total
    errors[1] = keep * errors[1] + 1.0
    variance = errors[0] / errors[1]
    for i in range(n):  # theta is (b, a), the parameters are (a, b)
        stddev[n + i] = math.sqrt(max(c[n + i, n + i], 0.0) * variance)
        stddev[2 * n + i] = math.sqrt(max(c[i, i], 0.0) * variance)
