"""The noise of the outputs: given, or learned from the residuals of accepted windows.

Correlated noise passes for a jump, and for more information than there is: its lag-1 correlation is
learned too.
"""

from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from obs_ros.core.residual_tests import LIMITS, Whiteness, squares_of
from obs_ros.core.typing import Array
from obs_ros.inference.objective import ROUNDING
from obs_ros.integration.grid import Grid

MEDIAN_BEND = 0.6745 * 6**0.5  # median of the second differences of unit white noise


@dataclass(frozen=True)
class NoiseSettings:
    """Limits in learning the noise.

    - `remembered`: accepted windows whose median is taken; more would follow a change too late.
    - `patience`: windows in a row unlike the others after which the noise has changed.
    """

    remembered: int = 20
    patience: int = 3


LEARNING = NoiseSettings()


class Leftover(NamedTuple):
    """Variances (r,) of the residuals of a window, in the outputs' units, and their colour."""

    variances: Array
    colour: Whiteness


@dataclass(frozen=True)
class NoiseMemory:
    """The windows that told the noise, and the latest ones in a row that were unlike them."""

    recent: tuple[Leftover, ...]
    odd: tuple[Leftover, ...]


class Noise:
    """Standard deviations of the outputs, learned from accepted windows where they are not given.

    With `learned` even the given ones are only starting values.
    """

    def __init__(self, given: Mapping[str, float], outputs: tuple[str, ...], learned: bool) -> None:
        fixed = [np.nan if learned else given.get(name, np.nan) for name in outputs]
        self._given = np.array(fixed)
        self._recent: deque[Leftover] = deque(maxlen=LEARNING.remembered)
        self._odd: list[Leftover] = []
        self._told: tuple[Array, float] | None = None  # scale and correlation by the recent windows

    @property
    def memory(self) -> NoiseMemory:
        """All that was learned."""
        return NoiseMemory(tuple(self._recent), tuple(self._odd))

    def recall(self, memory: NoiseMemory) -> None:
        """Know what another one learned, of the same outputs."""
        self._recent.clear()
        self._recent.extend(memory.recent)
        self._odd, self._told = list(memory.odd), None

    def scale(self) -> Array | None:
        """Return standard deviations (r,); None as long as one is neither given nor learned."""
        if self._recent:
            return self._by_windows()[0]
        return self._given if np.isfinite(self._given).all() else None

    @property
    def told_by(self) -> float:
        """Number of windows that told the noise; infinite where all of it is given."""
        return np.inf if np.isfinite(self._given).all() else float(len(self._recent))

    @property
    def correlation(self) -> float:
        """Lag-1 correlation of the noise; 0 unless the windows so far are not white by far."""
        return self._by_windows()[1] if self._recent else 0.0

    def _by_windows(self) -> tuple[Array, float]:
        """Return deviations (r,) and correlation by the windows accepted last."""
        if self._told is None:
            learned = np.sqrt(np.median([left for left, _ in self._recent], axis=0))
            scale = np.where(np.isfinite(self._given), self._given, learned)
            colours, correlation = [colour for _, colour in self._recent], 0.0
            if not np.median([colour.deviations for colour in colours]) < LIMITS.white:
                correlation = float(np.median([colour.correlation for colour in colours]))
            self._told = scale, correlation
        return self._told

    def accept(self, variances: Array, colour: Whiteness) -> None:
        """Learn from a window that its hypothesis explains, if its residuals have squares."""
        if not np.isfinite(variances).all():
            return
        self._recent.append(Leftover(variances, colour))
        self._told = None
        self._odd.clear()

    def doubt(self, variances: Array, colour: Whiteness) -> None:
        """Note a window unlike the others; when several in a row are, begin anew with them."""
        if not np.isfinite(variances).all():
            return
        self._odd.append(Leftover(variances, colour))
        if len(self._odd) >= LEARNING.patience:
            self._recent.clear()
            self._recent.extend(self._odd)
            self._told = None
            self._odd.clear()


def noise_guess(y: Array, nothing: float = 1.0, rounding: float = 0.0) -> float:
    """Guess the noise of one output (K,) from its second differences, which a slow signal lacks.

    `nothing` stands for a signal without any, or of too few values. Where the sensor rounds with
    errors of deviation `rounding`, most differences may be 0, and noise is as large at least.
    """
    y = y[np.isfinite(y)]
    if y.size < 3:
        return max(nothing, rounding)
    bends = np.sort(np.abs(np.diff(y, 2)))
    if rounding > 0.0:
        return max(float(bends[bends.size // 2]) / MEDIAN_BEND, rounding)
    for guess in (bends[bends.size // 2], np.std(y)):
        if guess > ROUNDING * np.abs(y).max():
            return float(guess) / MEDIAN_BEND
    return nothing


def variances_left(residuals: Array, grid: Grid, unknowns: int) -> Array:
    """Return noise variances (r,) in the outputs' units from scaled residuals (K, r) of a fit.

    NaN = not measured. The unknowns' share of the freedom is spread over the outputs. No variance
    is below that of the errors by which a sensor rounds.
    """
    counts, squares = squares_of(residuals)
    left = np.maximum(counts * (1.0 - unknowns / max(counts.sum(), 1)), 1.0)
    least = (ROUNDING * np.abs(grid.y).max(axis=0, initial=0.0)) ** 2 + np.finfo(float).tiny
    least = np.maximum(least, grid.rounding**2)
    found = squares / left * grid.scale**2
    # An output that was not measured in this window keeps its scale.
    return np.where(counts > 0, np.maximum(found, least), grid.scale**2)
