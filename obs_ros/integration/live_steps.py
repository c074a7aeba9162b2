"""Steps from one output to the next, chosen so that integration errors stay below the noise.

Observers that go sample by sample hand their candidates to a `LiveStepper`. It compares the way
from one output to the next with the same way in half the steps' length (step doubling; Hairer,
Nørsett & Wanner 1993, section II.4):

    error = |y_h - y_(h/2)| / noise

in every output y and candidate. Where that exceeds its tolerance, the candidates go the way again
in finer steps, before anything is corrected by the output at its end. Ways are compared at first,
then ever more rarely, and again at once where a candidate leaves the region that was compared.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from obs_ros.core.jit import accelerated, bound
from obs_ros.core.model import Model
from obs_ros.core.periods import periods, shortest_way
from obs_ros.core.typing import Array, IntArray
from obs_ros.integration.backends import Backend
from obs_ros.integration.filter_pass import sizes
from obs_ros.integration.filter_step import LiveFilter
from obs_ros.integration.grid import longest_step
from obs_ros.integration.path import LANES, Path
from obs_ros.integration.stepper import Stepper, stepper_for


@dataclass(frozen=True)
class LiveStepSettings:
    """Tolerances, and how often ways are compared.

    - `share`: error from one output to the next, in deviations of the noise and of the state. A
      filter remembers some tens of outputs, over which errors of one sign add up: so a hundredth.
    - `unknown_noise`: deviation taken for outputs whose noise is not known, in units of the values.
    - `rounding`: smallest error that is asked for, in units of the values: the backends agree to
      1e-9, and models hold differences of large numbers.
    - `first`: ways compared at the start, one after the other.
    - `rarest`: ways from one comparison to the next, at most; each costs some steps of a filter.
    - `most_halvings`: of steps, to find a length that is fine enough: some ms, rarely.
    - `most_steps`: steps over a gap, at most, as nothing can interrupt them; as the gate's.
    - `margin`: width around the region compared that is taken for the same, in units of the
      states' sizes (see `sizes`): a twentieth of their bounds' distance.
    """

    share: float = 0.01
    unknown_noise: float = 1e-3
    rounding: float = 1e-9
    first: int = 3
    rarest: int = 64
    most_halvings: int = 12
    most_steps: int = 100_000
    margin: float = 0.5


DEFAULT = LiveStepSettings()
NOWHERE = np.array([[np.inf], [-np.inf]])
ORDER = {'rk4': 4, 'euler': 1}  # of the error over a way


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
        """Whether the error is as good as the best one."""
        return self.diverged == best.diverged and self.worst <= factor * best.worst


class Trial(NamedTuple):
    """A way from one output to the next: its error, steps (pieces,) and states (n, L) at its end."""

    error: WayError
    steps: IntArray
    x: Array


class Way(NamedTuple):
    """A way of L candidates: states where it starts, and with outputs where it ends."""

    start: Array  # (n, L)
    fine: Array  # (n, L) at the end, by half the steps' length
    y: Array  # (r, L)
    y_fine: Array  # (r, L)


class Scales(NamedTuple):
    """The units of errors: `LiveStepSettings`, noise and deviations of the states."""

    noise: Array  # (r,) NaN = not known
    stddev: Array  # (n,) NaN or 0 = not known
    period: Array  # (r,) of the outputs, 0 for those without
    share: float
    unknown_noise: float
    rounding: float


class LiveStepper:
    """Steps candidates as `Stepper` does, in steps that it chooses.

    noise (r,) are the outputs' standard deviations, NaN = not known; stddev (n,) those of the
    states, NaN = not known, as they are whenever a way is compared.
    """

    def __init__(
        self, model: Model, backend: Backend | None, noise: Array, stddev: Array | None = None,
        settings: LiveStepSettings = DEFAULT,
    ) -> None:  # fmt: skip
        self.model = model
        self._settings = settings
        self._stepper = stepper_for(model, backend)
        self._base = longest_step(model)
        n = len(model.states)
        self._scales = Scales(
            noise, np.full(n, np.nan) if stddev is None else stddev, periods(model.outputs),
            settings.share, settings.unknown_noise, settings.rounding,
        )  # fmt: skip
        self._region = np.empty((2, n))  # between which ways were compared: lower and upper ends
        self._margin = settings.margin * sizes(model)[0, :n]
        self._region[:] = NOWHERE
        self._way = self._of_width(LANES)
        x, one = self._way.start, np.ones(1)
        self._strayed = bound(strayed, self._region, x, 1, one, one.astype(np.int64), 0.0)
        self._judged = bound(judged, self._way, self._scales, x)
        self._widened = bound(widened, self._region, self._margin, x, x)
        self.error = np.nan  # of the newest way compared, in deviations of the noise
        self.steps = 0  # that it took
        self._longest = self._base  # s
        self._compared = 0.0  # longest step (s) that was compared
        self._within = True  # whether steps of some length were fine enough
        # Ways to go and from now on between two comparisons, and comparisons in a row at the start.
        self._wait, self._pause, self._left = 1, 1, settings.first

    @property
    def name(self) -> str:
        """Name of the backend."""
        return self._stepper.name

    @property
    def compile_time(self) -> float:
        """Seconds that compiling took."""
        return self._stepper.compile_time

    @property
    def method(self) -> str:
        """Method that is in use."""
        return self._stepper.model.method

    def propagate(self, path: Path, x: Array, p: Array) -> None:
        """See `Stepper.propagate`."""
        if self._longest < self._base:
            path = self._laid(path)
        if self._way.start.shape != x.shape:
            self._way = self._of_width(x.shape[1])
        np.copyto(self._way.start, x)
        self._stepper.propagate(path, x, p)
        if self._due(path, x):
            self._compare(path, x, p)

    def measure(self, t: float, u: Array, x: Array, p: Array, y: Array) -> None:
        """See `Stepper.measure`."""
        self._stepper.measure(t, u, x, p, y)

    def filter(self, live: LiveFilter, path: Path, y: Array) -> None:
        """See `Stepper.filter`; the way of the mean is compared."""
        laid = self._laid(path) if self._longest < self._base else path
        start = [array.copy() for array in (live.x, live.p, live.P)]
        self._stepper.filter(live, laid, y)
        if not self._due(laid, live.x[:, None]):
            return
        x, p = (np.repeat(array[:, None], LANES, axis=1) for array in start[:2])
        if self._way.start.shape != x.shape:
            self._way = self._of_width(LANES)
        np.copyto(self._way.start, x)
        self._stepper.propagate(laid, x, p)
        if self._compare(laid, x, p):
            for array, values in zip((live.x, live.p, live.P), start, strict=True):
                array[:] = values
            self._stepper.filter(live, self._laid(path), y)

    def _of_width(self, width: int) -> Way:
        """Return arrays for a way of so many candidates."""
        n, r = len(self.model.states), len(self.model.outputs)
        return Way(*np.empty((2, n, width)), *np.empty((2, r, width)))

    def _laid(self, path: Path) -> Path:
        """Return the path in steps of the length that is in use."""
        steps = np.ceil(path.dt[: path.pieces] / self._longest)
        return path._replace(steps=np.clip(steps, 1, self._settings.most_steps).astype(np.int64))

    def _due(self, path: Path, x: Array) -> bool:
        """Whether the way to x (n, L) is to be compared."""
        self._wait -= 1
        if self._wait <= 0:
            return True
        return self._within and self._strayed(
            self._region, x, path.pieces, path.dt, path.steps, self._compared
        )

    def _compare(self, path: Path, x: Array, p: Array) -> bool:
        """Compare the way to x (n, L), and go it in finer steps where it errs by too much.

        Returns whether x (n, L) changed.
        """
        k = path.pieces
        ways = [Trial(self._error(path, x, p), path.steps[:k], x)]
        while not ways[-1].error.within and len(ways) <= self._settings.most_halvings:
            path = path._replace(steps=2 * path.steps[:k])
            states = self._way.fine.copy()
            ways.append(Trial(self._error(path, states, p), path.steps, states))
        # Where no way is within the tolerance, finer steps than of this one gain next to nothing.
        best = min(way.error for way in ways)
        way = next(way for way in ways if way.error.comparable(best))
        self.error, self.steps = way.error.sd, int(way.steps.sum())
        if changed := way.x is not x:
            x[:] = way.x
        self._plan(way.error, float((path.dt[:k] / way.steps).max()), changed=changed)
        if way.error.within:
            self._widened(self._region, self._margin, self._way.start, x)
        return changed

    def _plan(self, error: WayError, longest: float, *, changed: bool) -> None:
        """Choose the steps to come, and how many ways go by before the next comparison."""
        self._compared = max(self._compared, 1.01 * longest)
        self._within = error.within
        if changed:
            self._longest = self._compared = 1.01 * longest
        if not error.within:
            # No steps are fine enough here: they need not be sought again at once.
            self._pause = min(4 * self._pause, 16 * self._settings.rarest)
        elif changed:
            self._pause = 1
        elif self._longest < self._base and error.worst < 0.5 ** (ORDER[self.method] + 1):
            self._longest = min(2.0 * self._longest, self._base)
            self._pause = 1
            self._region[:] = NOWHERE
        elif self._left > 0:
            self._left -= 1
        else:
            self._pause = min(2 * self._pause, self._settings.rarest)
        self._wait = self._pause

    def _error(self, path: Path, x: Array, p: Array) -> WayError:
        """Return the error of the way to x (n, L); half the steps' length leads to `_fine`."""
        way, fine = self._way, self._way.fine
        np.copyto(fine, way.start)
        self._stepper.propagate(path._replace(steps=2 * path.steps[: path.pieces]), fine, p)
        t, u = path.t[path.pieces], path.u[path.pieces]
        self._stepper.measure(t, u, x, p, way.y)
        self._stepper.measure(t, u, fine, p, way.y_fine)
        return WayError(*self._judged(way, self._scales, x))


def live_stepper(
    model: Model, backend: Backend | None, noise: Array, stddev: Array | None = None
) -> Stepper:
    """Return a stepper that chooses its steps, or one in the steps of the method that is given."""
    if model.integrator != 'auto':
        return stepper_for(model, backend)
    return LiveStepper(model, backend, noise, stddev)


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
        if total < math.inf:
            worst = max(worst, total)
        else:
            diverged += 1
    return diverged, worst, sd


@accelerated
def larger(error: float, difference: float, scale: float, least: float) -> float:
    """Return the larger of an error and of a difference in units of the larger scale."""
    if difference == 0.0:
        return error
    ratio = abs(difference) / max(scale, abs(least))
    return max(error, ratio) if ratio < math.inf and error < math.inf else math.inf


@accelerated
def widened(region: Array, margin: Array, start: Array, x: Array) -> None:
    """Add the candidates' way from start (n, L) to x (n, L), and what lies around, to a region."""
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
