"""Autocorrelation of residuals: of a model that explains its data they are white noise."""

import math
from dataclasses import dataclass

import numpy as np

from obs_ros.core.chi_square import exceeds
from obs_ros.core.typing import Array


@dataclass(frozen=True)
class WhitenessSettings:
    """Lags that are shown, and when residuals are called white."""

    lags: int = 25
    least: int = 50  # residuals, below which nothing is said
    tail: float = 0.01  # probability that white noise is called coloured


SETTINGS = WhitenessSettings()


@dataclass(frozen=True)
class Autocorrelation:
    """Correlations (L,) of residuals at the lags 1 to L, and what white noise would have.

    Of white noise each lies within -bound to bound with probability 0.95. `white` is the test of
    Ljung & Box (1978), Biometrika 65, eq. 1.3, over all lags; None where there are too few.
    """

    values: Array
    bound: float
    count: int
    white: bool | None

    @property
    def words(self) -> str:
        """What is found, in a sentence."""
        if self.white is None:
            return f'{self.count} residuals: too few to judge, {SETTINGS.least} are needed'
        outside = int((np.abs(self.values) > self.bound).sum())
        rest = f'{outside} of {self.values.size} lags outside, of {self.count} residuals'
        if self.white:
            return f'white: {rest}'
        return f'not white: {rest}; the model or the noise leaves something out'


def autocorrelation(residuals: Array, settings: WhitenessSettings = SETTINGS) -> Autocorrelation:
    """Return the autocorrelation of residuals (K,), over those that are finite.

    Their mean is not taken away: residuals of a right model have the mean 0, and one that is not
    is what shall be seen.
    """
    r = residuals[np.isfinite(residuals)]
    lags = min(settings.lags, max(r.size - 1, 0))
    square = float(r @ r)
    products = np.array([r[lag:] @ r[:-lag] for lag in range(1, lags + 1)])
    values = products / square if square > 0.0 else np.zeros(lags)
    bound = 1.96 / math.sqrt(r.size) if r.size else math.nan
    white = None
    if r.size >= settings.least and square > 0.0:
        weights = r.size * (r.size + 2.0) / (r.size - np.arange(1, lags + 1))
        white = not exceeds(float(weights @ values**2), lags, settings.tail)
    return Autocorrelation(values, bound, int(r.size), white)
