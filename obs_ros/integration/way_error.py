"""The error of candidates on their way from one output to the next, by two lengths of steps."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from obs_ros.core.jit import accelerated
from obs_ros.core.periods import shortest_way
from obs_ros.core.typing import Array, IntArray


@dataclass(frozen=True)
class LiveStepSettings:
    """Tolerances from output to output, and how often ways are compared.

    - `share`: error of a way, in deviations of the noise and of the states. A filter remembers tens
      of outputs, over which errors of one sign add up: a hundredth becomes the tenth at which
      `StepSettings.aimed` stands for windows.
    - `sensitivity`: error of what one candidate is off another at the end of a way, as a share of
      what it is off there or at the start: filters linearise by such differences, and the gains
      that follow hardly change by a percent.
    - `unknown_noise`: deviation taken for outputs whose noise is not known, in units of the values.
    - `rounding`: smallest error that is asked for, in units of the values: the backends agree to
      1e-9, and models hold differences of large numbers.
    - `lost`: error, in units of what is allowed, from which on a candidate counts as diverged: then
      it says nothing of the steps that others need.
    - `first`: ways compared at the start, one after the other.
    - `rarest`: ways from one comparison to the next, at most; a comparison costs half of what a
      filter takes for an output.
    - `calm`: comparisons in a row after which steps may grow: at first, and at most where they had
      to shrink again at once, as of a plant whose inputs jump.
    - `most_halvings`: of steps, to find a length that is fine enough: some ms, rarely.
    - `most_steps`: steps over a gap, at most, as nothing can interrupt them; as the gate's.
    - `margin`: width around the region compared that is taken for the same, in units of the
      states' sizes (see `sizes`): a twentieth of their bounds' distance.
    - `leap`: leaps of inputs, in those of ways compared, up to which they count for the same.
    """

    share: float = 0.01
    sensitivity: float = 0.01
    unknown_noise: float = 1e-3
    rounding: float = 1e-9
    lost: float = 1e6
    first: int = 3
    rarest: int = 64
    calm: tuple[int, int] = (4, 64)
    most_halvings: int = 12
    most_steps: int = 100_000
    margin: float = 0.5
    leap: float = 1.2


DEFAULT = LiveStepSettings()
NOWHERE = np.array([[np.inf], [-np.inf]])


class WayError(NamedTuple):
    """The error of a way: candidates that diverged, and the worst of the others' errors.

    `worst` is in units of the tolerance, over outputs and states; `sd` is that of the mean's
    outputs, in deviations of their noise.
    """

    diverged: int
    worst: float
    sd: float

    @property
    def within(self) -> bool:
        """Whether all candidates keep to the tolerance."""
        return not self.diverged and self.worst <= 1.0

    def comparable(self, best: 'WayError', factor: float = 4.0) -> bool:
        """Whether the error is within the tolerance, or as good as the best one."""
        return self.diverged == best.diverged and self.worst <= max(1.0, factor * best.worst)


class Trial(NamedTuple):
    """A way that was tried: its error, method, steps (pieces,), and states (n, L) at its end."""

    error: WayError
    method: str
    steps: IntArray
    x: Array


class Way(NamedTuple):
    """A way of L candidates: states where it starts, and with outputs where it ends."""

    start: Array  # (n, L)
    fine: Array  # (n, L) at the end, by half the steps' length
    y: Array  # (r, L)
    y_fine: Array  # (r, L)

    @classmethod
    def of(cls, states: int, outputs: int, width: int) -> 'Way':
        """Return arrays for so many candidates."""
        return cls(*np.empty((2, states, width)), *np.empty((2, outputs, width)))


class Scales(NamedTuple):
    """The units of errors: `LiveStepSettings`, noise and deviations of the states."""

    noise: Array  # (r,) NaN = not known
    stddev: Array  # (n,) NaN or 0 = not known
    period: Array  # (r,) of the outputs, 0 for those without
    size: Array  # (n,) of the states
    share: float
    sensitivity: float
    unknown_noise: float
    rounding: float
    lost: float


@accelerated
def judged(way: Way, scales: Scales, x: Array) -> tuple[int, float, float]:
    """Return the entries of `WayError` for x (n, L) beside the way in half the steps' length."""
    fine, y, y_fine = way.fine, way.y, way.y_fine
    noise, stddev, period, share = scales.noise, scales.stddev, scales.period, scales.share
    diverged, worst, sd = 0, 0.0, 0.0
    for lane in range(x.shape[1]):
        total = 0.0
        for i in range(x.shape[0]):
            scale = share * stddev[i] if stddev[i] > 0.0 else math.inf
            total = larger(
                total, x[i, lane] - fine[i, lane], scale, scales.rounding * fine[i, lane]
            )
        for i in range(y.shape[0]):
            size = abs(y_fine[i, lane])
            deviation = scales.unknown_noise * size if math.isnan(noise[i]) else noise[i]
            off = shortest_way(y[i, lane] - y_fine[i, lane], period[i])
            total = larger(total, off, share * deviation, scales.rounding * size)
            if lane == 0:
                sd = larger(sd, off, deviation, 0.0)
        total = max(total, difference_error(way, scales, x, lane))
        if total < scales.lost:
            worst = max(worst, total)
        else:
            diverged += 1
    return diverged, worst, sd


@accelerated
def difference_error(way: Way, scales: Scales, x: Array, lane: int) -> float:
    """Return the error of what a candidate is off the first one, in units of the tolerance."""
    start, fine, error, most = way.start, way.fine, 0.0, 0.0
    for i in range(x.shape[0]):
        off = fine[i, lane] - fine[i, 0]
        error = max(error, abs(x[i, lane] - x[i, 0] - off) / scales.size[i])
        most = max(most, abs(off) / scales.size[i])
        most = max(most, abs(start[i, lane] - start[i, 0]) / scales.size[i])
        most = max(most, scales.rounding * abs(fine[i, 0]) / scales.size[i])
    return error / (scales.sensitivity * most) if error > 0.0 else 0.0


@accelerated
def larger(error: float, difference: float, scale: float, least: float) -> float:
    """Return the larger of an error and of a difference in units of the larger scale."""
    if difference == 0.0:
        return error
    ratio = abs(difference) / max(scale, abs(least))
    return max(error, ratio) if ratio < math.inf and error < math.inf else math.inf


@accelerated
def widened(region: Array, margin: Array, start: Array, x: Array) -> None:
    """Add the candidates' way from start (n, L) to x (n, L), and what lies around, to a region.

    The region (2, n) has lower and upper ends; margin (n,) is the width around a way.
    """
    for i in range(x.shape[0]):
        least, most = start[i, 0], start[i, 0]
        for lane in range(x.shape[1]):
            least = min(least, min(start[i, lane], x[i, lane]))
            most = max(most, max(start[i, lane], x[i, lane]))
        around = margin[i] + 0.1 * (most - least)
        region[0, i] = min(region[0, i], least - around)
        region[1, i] = max(region[1, i], most + around)


@accelerated
def strayed(
    region: Array, x: Array, pieces: int, dt: Array, steps: IntArray, longest: float
) -> bool:
    """Whether an entry of x (n, L) is not within the region (2, n), or a step is too long (s)."""
    for k in range(pieces):
        if dt[k] > longest * steps[k]:
            return True
    for i in range(x.shape[0]):
        for lane in range(x.shape[1]):
            if not (x[i, lane] >= region[0, i] and x[i, lane] <= region[1, i]):
                return True
    return False


@accelerated
def leapt(
    leap: Array, seen: Array, last: Array, pieces: int, dt: Array, u: Array, slope: Array
) -> bool:
    """Whether an input leaps by more than `seen` (m,) where a piece of the path begins.

    The largest leaps become `leap` (m,). Where the path before ended inputs were `last` (m,), which
    becomes the end of this one's last piece; NaN there counts for no leap.
    """
    beyond = False
    for i in range(leap.size):
        leap[i] = 0.0
        for k in range(pieces):
            off = abs(u[k, i] - last[i])
            if off > leap[i]:
                leap[i] = off
            last[i] = u[k, i] + dt[k] * slope[k, i]
        beyond = beyond or leap[i] > seen[i]
    return beyond
