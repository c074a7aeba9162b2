"""Method and steps from one output to the next, such that errors stay far below the noise.

Observers that go sample by sample hand their candidates to a `LiveStepper`. It compares the way
from one output to the next with the same way in half the steps' length (step doubling; Hairer,
Nørsett & Wanner 1993, section II.4):

    error = |y_h - y_(h/2)| / noise

in every output y and candidate. Where that exceeds its tolerance, the candidates go the way again
in finer steps, or by a linearly implicit method where that is stiff, before they are corrected by
its output. Ways are compared at first, then ever more rarely, and at once where a candidate leaves
the region compared or an input leaps farther than there: at rest a stiff state needs no steps.
"""

import numpy as np

from obs_ros.core.jit import bound
from obs_ros.core.model import Model
from obs_ros.core.periods import periods
from obs_ros.core.typing import Array
from obs_ros.integration.backends import Backend
from obs_ros.integration.filter_pass import sizes
from obs_ros.integration.filter_step import LiveFilter
from obs_ros.integration.grid import longest_step
from obs_ros.integration.path import LANES, Path
from obs_ros.integration.step_cost import cost_of_step
from obs_ros.integration.step_trials import ORDERS, STEPPING
from obs_ros.integration.stepper import Stepper, stepper_for
from obs_ros.integration.time_scales import STIFF, fastest_decay, may_be_stiff, modes
from obs_ros.integration.way_error import (
    DEFAULT,
    NOWHERE,
    LiveStepSettings,
    Scales,
    Trial,
    Way,
    WayError,
    judged,
    leapt,
    strayed,
    widened,
)
from obs_ros.integration.window_steps import by_method

IMPLICIT = 'rosenbrock'
SAME = 1.01  # of a step: stamps jitter by some share of the interval


class LiveStepper:
    """Steps candidates as `Stepper` does, by the method and in the steps that it chooses.

    noise (r,) are the outputs' standard deviations, NaN = not known; stddev (n,) those of the
    states, as they are whenever a way is compared, NaN = not known.
    """

    def __init__(
        self, model: Model, backend: Backend | None, noise: Array, stddev: Array | None = None,
        settings: LiveStepSettings = DEFAULT,
    ) -> None:  # fmt: skip
        self.model, self.method = model, str(model.method)
        self.error = np.nan  # of the newest way compared, in deviations of the noise
        self.steps = 0  # that it took
        self._backend, self._settings = backend, settings
        first = self._stepper = stepper_for(model, backend)
        self.name, self.compile_time = first.name, first.compile_time
        self._base = self._longest = longest_step(model)  # s
        self._compared = 0.0  # longest step (s) that was compared
        self._within = True  # whether steps of some length were fine enough
        # Ways to go and from now on between two comparisons, and comparisons in a row at the start.
        self._wait, self._pause, self._left = 1, 1, settings.first
        # Comparisons since the steps changed and until they may grow; whether they grew last.
        self._calm, self._patience, self._grown = 0, settings.calm[0], False
        self._prepare(noise, stddev)

    def _prepare(self, noise: Array, stddev: Array | None) -> None:
        """Lay out the arrays, and compile what judges them."""
        n, settings = len(self.model.states), self._settings
        size = sizes(self.model)[0, :n]
        self._scales = Scales(
            noise, np.full(n, np.nan) if stddev is None else stddev, periods(self.model.outputs),
            size, settings.share, settings.sensitivity, settings.unknown_noise, settings.rounding,
            settings.lost,
        )  # fmt: skip
        self._region = np.empty((2, n))  # between which ways were compared: lower and upper ends
        self._margin = settings.margin * size
        self._region[:] = NOWHERE
        self._way = Way.of(n, noise.size, LANES)
        x, one = self._way.start, np.ones(1)
        self._strayed = bound(strayed, self._region, x, 1, one, one.astype(np.int64), 0.0)
        self._judged = bound(judged, self._way, self._scales, x)
        self._widened = bound(widened, self._region, self._margin, x, x)
        # Leaps of inputs (m,) on the way and on ways compared, and where the way before ended.
        self._leap, self._seen, self._last = u = np.zeros((3, len(self.model.inputs)))
        self._last[:] = np.nan
        self._leapt = bound(leapt, self._leap, self._seen, self._last, 1, one, u, u)

    def propagate(self, path: Path, x: Array, p: Array) -> None:
        """See `Stepper.propagate`."""
        if self._longest < self._base:
            path = self._laid(path)
        self._set_out(x)
        self._stepper.propagate(path, x, p)
        if self._due(path, x):
            self._compare(path, x, p)

    def measure(self, t: float, u: Array, x: Array, p: Array, y: Array) -> None:
        """See `Stepper.measure`."""
        self._stepper.measure(t, u, x, p, y)

    def filter(self, live: LiveFilter, path: Path, y: Array) -> None:
        """See `Stepper.filter`; the way of the mean is compared, with the filter's deviations."""
        laid = self._laid(path) if self._longest < self._base else path
        start = [array.copy() for array in (live.x, live.p, live.P)]
        self._stepper.filter(live, laid, y)
        if not self._due(laid, live.x[:, None]):
            return
        self._scales.stddev[:] = np.sqrt(np.maximum(start[2].diagonal()[: live.x.size], 0.0))
        x, p = (np.repeat(array[:, None], LANES, axis=1) for array in start[:2])
        self._set_out(x)
        self._stepper.propagate(laid, x, p)
        if found := self._compare(laid, x, p):
            for array, values in zip((live.x, live.p, live.P), start, strict=True):
                array[:] = values
            self._stepper.filter(live, path._replace(steps=found.steps), y)

    def _set_out(self, x: Array) -> None:
        """Remember where the candidates x (n, L) start."""
        if self._way.start.shape != x.shape:
            self._way = Way.of(len(x), self._scales.noise.size, x.shape[1])
        np.copyto(self._way.start, x)

    def _laid(self, path: Path) -> Path:
        """Return the path in steps of the length that is in use."""
        steps = np.ceil(path.dt[: path.pieces] / self._longest)
        return path._replace(steps=np.clip(steps, 1, self._settings.most_steps).astype(np.int64))

    def _due(self, path: Path, x: Array) -> bool:
        """Whether the way to x (n, L) is to be compared."""
        k, dt = path.pieces, path.dt
        leapt = self._leapt(self._leap, self._seen, self._last, k, dt, path.u, path.slope)
        self._wait -= 1
        if self._wait <= 0:
            return True
        return self._within and (
            leapt or self._strayed(self._region, x, k, dt, path.steps, self._compared)
        )

    def _compare(self, path: Path, x: Array, p: Array) -> Trial | None:
        """Compare the way to x (n, L), and go it in other steps where it errs by too much.

        Returns the way that was gone instead, if x (n, L) changed.
        """
        k = path.pieces
        first = Trial(self._error(self._stepper, path, x, p), self.method, path.steps[:k], x)
        best = self._best(first, path, p)
        self.error, self.steps = best.error.sd, int(best.steps.sum())
        if best.method != self.method:
            self.method, self._stepper = best.method, self._by(best.method)
        if best is not first:
            x[:] = best.x
        self._plan(best, float((path.dt[:k] / best.steps).max()), changed=best is not first)
        if best.error.within:
            self._widened(self._region, self._margin, self._way.start, x)
            np.maximum(self._seen, self._settings.leap * self._leap, out=self._seen)
        return None if best is first else best

    def _best(self, first: Trial, path: Path, p: Array) -> Trial:
        """Return the cheapest way that errs little enough, or else about the least."""
        explicit = first.method != IMPLICIT
        if first.error.within and explicit:
            return first
        stiff = self._stiff(path, first.x, p)
        if first.error.within and stiff:
            return first
        trials, limit = [first], np.inf
        if not first.error.within and (stiff or not explicit):
            trials += self._refined(IMPLICIT, first, path, p, limit)
        if trials[-1].error.within:
            # RK4 is compiled already, and its errors are smooth: it stays where it costs as much.
            limit = self._cost(trials[-1]) * (STEPPING.cheaper if explicit else 1.0)
        if explicit or not stiff:
            trials += self._refined('rk4', first, path, p, limit)
        fine = [trial for trial in trials if trial.error.within]
        if fine:
            return fine[-1]
        # Finer steps than of this one gain next to nothing.
        best = min(trial.error for trial in trials)
        return next(trial for trial in trials if trial.error.comparable(best))

    def _refined(
        self, method: str, first: Trial, path: Path, p: Array, limit: float
    ) -> list[Trial]:
        """Return ways by a method in ever finer steps until one errs little enough.

        They go on from the first way if that is by this method, and cost no more than the limit.
        """
        trials: list[Trial] = []
        steps = 2 * first.steps
        if method != first.method:
            fewest = np.ceil(path.dt[: path.pieces] / self._base)
            steps = np.maximum(1, fewest).astype(np.int64)
        for _ in range(self._settings.most_halvings):
            x = self._way.start.copy()
            way = path._replace(steps=steps)
            stepper = self._by(method)
            trial = Trial(WayError(0, np.nan, np.nan), method, steps, x)
            if self._cost(trial) > limit:
                break
            stepper.propagate(way, x, p)
            trials.append(trial._replace(error=self._error(stepper, way, x, p)))
            if trials[-1].error.within:
                break
            steps = 2 * steps
        return trials

    def _cost(self, trial: Trial) -> float:
        """Return what a way costs one candidate, in operations on numbers."""
        return cost_of_step(self.model, trial.method) * float(trial.steps.sum())

    def _by(self, method: str) -> Stepper:
        """Return the steps of a method; its first call compiles."""
        return stepper_for(by_method(self.model, method), self._backend)

    def _stiff(self, path: Path, x: Array, p: Array) -> bool:
        """Whether a mode decays so fast, where the way starts or ends, that RK4 may cost more."""
        longest = path.dt[: path.pieces].max()
        for k, states in ((0, self._way.start), (path.pieces, x)):
            found = modes(self.model, path.t[k], states[:, 0], path.u[k], p[:, 0])
            if fastest_decay(found) * longest > STIFF.decay:
                return True
        return False

    def _plan(self, gone: Trial, longest: float, *, changed: bool) -> None:
        """Choose the steps to come, and how many ways go by before the next comparison.

        The way gone took steps of `longest` s at most; `changed` says that others were planned.
        """
        error, calm = gone.error, self._settings.calm
        self._compared = max(self._compared, SAME * longest)
        self._within = error.within
        self._calm += 1
        if changed:
            self._longest = self._compared = SAME * longest
            # Steps that were too long soon after they grew grow more rarely.
            self._patience = min(2 * self._patience, calm[1]) if self._grown else calm[0]
            self._calm, self._grown = 0, False
        if not error.within:
            # No steps are fine enough here: they need not be sought again at once.
            self._pause = min(4 * self._pause, 16 * self._settings.rarest)
        elif changed:
            self._pause = 1
        elif self._may_grow(error) and self._calm >= self._patience:
            self._longest = min(2.0 * self._longest, self._base)
            self._pause, self._calm, self._grown = 1, 0, True
            self._region[:], self._seen[:] = NOWHERE, 0.0
        elif self._left > 0:
            self._left -= 1
        else:
            self._pause = min(2 * self._pause, self._settings.rarest)
        self._wait = self._pause

    def _may_grow(self, error: WayError) -> bool:
        """Whether steps of twice the length would err little enough, by the order of the method."""
        return self._longest < self._base and error.worst < 0.5 ** (ORDERS[self.method] + 1)

    def _error(self, stepper: Stepper, path: Path, x: Array, p: Array) -> WayError:
        """Return the error of the way to x (n, L); half the steps' length leads to `Way.fine`."""
        way, k = self._way, path.pieces
        np.copyto(way.fine, way.start)
        stepper.propagate(path._replace(steps=2 * path.steps[:k]), way.fine, p)
        stepper.measure(path.t[k], path.u[k], x, p, way.y)
        stepper.measure(path.t[k], path.u[k], way.fine, p, way.y_fine)
        return WayError(*self._judged(way, self._scales, x))


def prepare(model: Model, backend: Backend | None) -> list[Stepper]:
    """Compile the methods that a model is likely to need; return their steps."""
    found = [stepper_for(model, backend)]
    if model.integrator == 'auto' and may_be_stiff(model):
        found.append(stepper_for(by_method(model, IMPLICIT), backend))
    return found


def figures_of(stepper: Stepper | None) -> dict[str, float]:
    """Return the error of the newest way compared, and its steps, if the stepper chooses them."""
    if not isinstance(stepper, LiveStepper) or not stepper.steps:
        return {}
    return {
        'integration_error_sd': stepper.error,
        f'integration_steps.{stepper.method}': float(stepper.steps),
    }


def live_stepper(
    model: Model, backend: Backend | None, noise: Array, stddev: Array | None = None
) -> Stepper:
    """Return a stepper that chooses its steps, or one in the steps of the method that is given."""
    if model.integrator != 'auto':
        return stepper_for(model, backend)
    return LiveStepper(model, backend, noise, stddev)
