"""Scatter of disjoint windows beside the standard deviations that they publish.

Windows that share no sample, each by itself, should differ by no more than their deviations s_k
say. Over the latest of them, with weights 1 / s_k^2, the factor of a parameter is

    factor^2 = sum_k (m_k - m)^2 / s_k^2 / (n - 1),    m their weighted median,

the ratio of Birge (1932, Phys. Rev. 40, 207-227), in which no window counts for more than three
deviations of the typical one, as in Winsor's variance: a plant that sticks for a while must not
make all other windows uncertain. Deviations are raised by it where it is above 1:
they then hold what the model leaves out from window to window, whatever that is.
"""

from dataclasses import dataclass

import numpy as np

from obs_ros.core.linear_algebra import scaled_inverse
from obs_ros.core.typing import Array, IntArray
from obs_ros.inference.assessment.identifiability import undetermined
from obs_ros.inference.assessment.interval import Interval
from obs_ros.inference.assessment.uncertainty import Uncertainty
from obs_ros.inference.parameterisation import BOX_VARIANCE


@dataclass(frozen=True)
class ScatterSettings:
    """Disjoint windows that are compared: so many at least, and at most.

    `outlier`: typical deviations, or published ones if these are larger, that one counts for at
    most.
    """

    fewest: int = 4
    most: int = 20
    outlier: float = 3.0


SCATTER = ScatterSettings()
NORMAL_MEDIAN = 0.6745  # of the absolute values of unit normal ones


@dataclass(frozen=True)
class Alone:
    """Parameters (q,) and their deviations (q,), in boxes, by one window without any other."""

    start: float
    end: float
    mean: Array
    deviation: Array

    @classmethod
    def of(cls, uncertainty: Uncertainty, inflation: float) -> 'Alone':
        """Take the prior out of a window's posterior; NaN stands for what it does not determine.

        A deviation larger than the window's information makes it is kept.
        """
        best = uncertainty.hypothesis
        unknowns, prior = best.problem.objective.unknowns, best.problem.prior
        n, t = unknowns.n_states, best.problem.objective.grid.t
        final = best.final_parameters
        given, box = prior.precision[n:, n:], np.eye(final.size) / BOX_VARIANCE
        m = best.point[final]
        own = scaled_inverse(uncertainty.information - prior.information(final.size) + box)
        mean = m + own @ (given @ (m - prior.mean[n:]) - box @ (m - 0.5))
        published = np.diagonal(uncertainty.covariance)[final]
        deviation = np.sqrt(inflation * np.maximum(np.diagonal(own), published))
        # What walks may differ from window to window.
        told = (deviation < undetermined(unknowns)[n:]) & ~np.isfinite(unknowns.walks)
        return cls(
            float(t[0]), float(t[-1]),
            np.where(told, mean, np.nan), np.where(told, deviation, np.nan),
        )  # fmt: skip


class Scatter:
    """The latest windows, each as it is without the others."""

    def __init__(self, settings: ScatterSettings = SCATTER) -> None:
        self._settings = settings
        self._windows: list[Alone] = []

    @property
    def memory(self) -> tuple[Alone, ...]:
        """All windows that are known."""
        return tuple(self._windows)

    def recall(self, memory: tuple[Alone, ...]) -> None:
        """Know the windows that another one knew."""
        self._windows = list(memory)

    def add(self, window: Alone) -> None:
        """Remember a window."""
        self._windows.append(window)
        oldest = window.end - (self._settings.most + 1) * (window.end - window.start)
        self._windows = [one for one in self._windows if one.start >= oldest]

    def forget(self) -> None:
        """Forget all windows: parameters have jumped."""
        self._windows.clear()

    def factors(self) -> Array | None:
        """Return the factor of each parameter (q,); NaN, or None, while there are too few."""
        disjoint: list[Alone] = []
        for one in reversed(self._windows):
            if len(disjoint) < self._settings.most and (
                not disjoint or one.end <= disjoint[-1].start
            ):
                disjoint.append(one)
        if len(disjoint) < self._settings.fewest:
            return None
        means, deviations = (
            np.array([getattr(one, name) for one in disjoint]) for name in ('mean', 'deviation')
        )
        return np.array([
            self._factor(m[told], s[told])
            for m, s in zip(means.T, deviations.T, strict=True)
            for told in [np.isfinite(m)]
        ])  # fmt: skip

    def _factor(self, means: Array, deviations: Array) -> float:
        """Return the factor of one parameter by means (n,) and deviations (n,)."""
        if means.size < self._settings.fewest:
            return np.nan
        order, weights = np.argsort(means), deviations**-2.0
        share = np.cumsum(weights[order]) / weights.sum()
        middle = means[order][int(np.searchsorted(share, 0.5))]
        off = np.abs(means - middle) / deviations
        most = self._settings.outlier * max(1.0, float(np.median(off)) / NORMAL_MEDIAN)
        return float(np.sqrt(np.sum(np.minimum(off, most) ** 2) / (means.size - 1)))


def raised(covariance: Array, places: IntArray, factors: Array | None) -> Array:
    """Return a covariance (D, D) with the deviations at `places` (q,) times factors above 1."""
    if factors is None:
        return covariance
    scale = np.ones(len(covariance))
    scale[places] = np.fmax(factors, 1.0)
    return np.asarray(covariance * np.outer(scale, scale))


def widened(interval: Interval | None, factors: Array | None) -> Interval | None:
    """Return intervals, those with factors above 1 as much longer."""
    if interval is None or factors is None:
        return interval
    return interval.widened(np.fmax(factors, 1.0))
