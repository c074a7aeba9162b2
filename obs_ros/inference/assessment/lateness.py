"""Signals that look late: residuals that go with the rate of an output, whatever the parameters do.

An output measured d s before its stamp leaves the residual r = -d g, with g = -dy/dt of the fitted
output in units of the noise, as far as the unknowns z of the fit do not make up for it. With
Jacobian J and covariance C of z, M = 1 - J C J' takes away all that they explain, and to first
order

    d = -(g' M r) / (g' M g),    gain = (g' M r)^2 / (g' M g),    var d = 1 / (g' M g):

the Lagrange multiplier test of one more parameter (Engle 1984, Handbook of Econometrics II, chapter
13). All outputs late by the same look like inputs that act late.
"""

import math
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from obs_ros.core.changes import replace
from obs_ros.core.estimate import Estimate
from obs_ros.core.model import names
from obs_ros.core.typing import Array
from obs_ros.inference.jumps.hypothesis import Hypothesis


@dataclass(frozen=True)
class LatenessSettings:
    """Limits in calling a signal late.

    Of springs at 50 Hz, 40 dB, windows of 3 s, an offset of a quarter to five sample intervals
    takes away 70 to 99 % of the squares beyond noise. Friction, wind, other springs and dampers
    leave 13 % at most to an offset that is not there. A drive that lags by a sample interval looks
    late by as much, and is.

    - `share`: of the squares beyond noise that the offset must take away;
    - `gain`: squares, in units of the noise, that it must take away: 5 deviations;
    - `beyond`: share of all squares that must be beyond noise, which is told by second differences
      of the residuals: slow noise passes for more, white noise for less than that;
    - `windows`: in a row that must say the same: chance and disturbances do not repeat themselves;
    - `agree`: ratio of the largest of their delays to the least.
    """

    share: float = 0.65
    gain: float = 25.0
    beyond: float = 0.1
    windows: int = 3
    agree: float = 1.5


LATENESS = LatenessSettings()


@dataclass(frozen=True)
class Late:
    """A signal that looks late by `delay` s, early where that is negative."""

    signal: str
    delay: float

    def __str__(self) -> str:
        """Say so, in ms."""
        way = 'late' if self.delay > 0.0 else 'early'
        verb = 'look' if ' and ' in self.signal else 'looks'
        return f'{self.signal} {verb} {float(f"{abs(self.delay) * 1e3:.2g}"):g} ms {way}'

    def agrees(self, other: 'Late', settings: LatenessSettings = LATENESS) -> bool:
        """Whether another window says the same."""
        ratio = self.delay / other.delay
        return self.signal == other.signal and 1.0 / settings.agree <= ratio <= settings.agree


class LateSignals:
    """The signals that looked late in the windows so far."""

    def __init__(self, settings: LatenessSettings = LATENESS) -> None:
        self._settings = settings
        self._recent: deque[Late | None] = deque(maxlen=settings.windows)

    @property
    def memory(self) -> tuple[Late | None, ...]:
        """What the latest windows said."""
        return tuple(self._recent)

    def recall(self, memory: tuple[Late | None, ...]) -> None:
        """Know what another one knew."""
        self._recent.clear()
        self._recent.extend(memory)

    def told(self, estimate: Estimate, plain: Hypothesis) -> Estimate:
        """Return the estimate with a remark, where its window and those before say the same.

        `plain` is the window's best hypothesis without process noise.
        """
        late = looks_late(plain, self._settings)
        self._recent.append(late)
        if late is None or len(self._recent) < self._settings.windows:
            return estimate
        agreed = all(
            each is not None and late.agrees(each, self._settings) for each in self._recent
        )
        return remarked(estimate, str(late)) if agreed else estimate


def looks_late(best: Hypothesis, settings: LatenessSettings = LATENESS) -> Late | None:
    """Return the signal whose offset would explain nearly all that noise does not, if one would."""
    residual = best.linearisation.residual
    squares = float(residual @ residual)
    beyond = squares - _noise_squares(best)
    if best.jumps or not beyond > settings.beyond * squares:
        return None
    signal, delay, gain = max(_offsets(best), key=lambda offset: offset[2], default=('', 0.0, 0.0))
    least = max(settings.gain, settings.share * beyond)
    return Late(signal, delay) if least < gain < math.inf else None


def remarked(estimate: Estimate, remark: str) -> Estimate:
    """Return the estimate with a remark at the end of its message, '' for none."""
    return replace(estimate, message=f'{estimate.message}; {remark}') if remark else estimate


def _offsets(best: Hypothesis) -> Iterator[tuple[str, float, float]]:
    """Yield signals with the delay (s) that each seems to have, and the squares it explains."""
    model = best.problem.objective.unknowns.model
    J, residual = best.linearisation.jacobian, best.linearisation.residual
    rates = _rates(best)
    signals = list(zip(names(model.outputs), rates.T, strict=True))
    if model.inputs and len(signals) > 1:
        signals.append((' and '.join(names(model.inputs)), rates.sum(axis=1)))
    score = residual - J @ (best.covariance @ (J.T @ residual))
    for signal, g in signals:
        projected = J.T @ g
        size = float(g @ g - projected @ best.covariance @ projected)
        # What the unknowns explain all but wholly is a parameter already.
        if size > 1e-6 * float(g @ g):
            slope = float(g @ score)
            yield signal, -slope / size, slope * slope / size


def _rates(best: Hypothesis) -> Array:
    """Return the derivatives (M, r) of the scaled residuals by each output's delay, in 1 / s."""
    grid, residual = best.problem.objective.grid, best.residuals
    known = grid.weight > 0.0
    rates = np.zeros((*known.shape, known.shape[1]))
    for i, own in enumerate(np.isfinite(residual).T):
        if np.count_nonzero(own) > 2:
            fitted = grid.y[own, i] + residual[own, i] / grid.weight[own, i]
            rates[own, i, i] = -grid.weight[own, i] * np.gradient(fitted, grid.t[own])
    return rates[known]


def _noise_squares(best: Hypothesis) -> float:
    """Return the squares that white noise has in the residuals, by their second differences."""
    total = 0.0
    for column in best.residuals.T:
        r = column[np.isfinite(column)]
        if r.size > 2:
            total += r.size * float(np.mean(np.diff(r, 2) ** 2)) / 6.0
    return total
