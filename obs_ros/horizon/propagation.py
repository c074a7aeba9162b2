"""From an estimate on to newer outputs: by the model alone, or corrected by these outputs.

The state x and the parameters p of an estimate have the joint covariance P. Without process noise

    x(t) = phi(t; x_0, p),    P_x(t) = G P G',    G = d phi / d (x_0, p),

outputs correct nothing: as long as the model holds, the window has told more than they could. With
it, the near future is in the newest outputs: an extended Kalman filter goes on from the window's
end (Jazwinski 1970, section 8.3), corrected by outputs that pass the gate for innovations.
Parameters without a walk stay those that the estimate tells; their covariance counts, see
`filter_step`.
"""

from collections.abc import Sequence
from typing import NamedTuple, Protocol

import numpy as np

from obs_ros.core.estimate import Estimate
from obs_ros.core.jit import accelerated
from obs_ros.core.model import Model, inside, names
from obs_ros.core.periods import nearest, periods, shortest
from obs_ros.core.saturation import contradicting, ends_of
from obs_ros.core.typing import Array, BoolArray, IntArray
from obs_ros.inference.innovation_gate import (
    INNOVATION_GATE,
    REJECTED,
    Gate,
    InnovationGateSettings,
    judged,
)
from obs_ros.integration import live_steps
from obs_ros.integration.backends import Backend
from obs_ros.integration.filter_pass import Differences
from obs_ros.integration.filter_step import LiveFilter
from obs_ros.integration.live_steps import live_stepper
from obs_ros.integration.path import Path, after, joined, lanes
from obs_ros.integration.stepper import tiny_path


class Interval(NamedTuple):
    """From one output, at `begin` (ns), to the next at `end`: inputs, and outputs y (r,) there.

    NaN = not measured; `stuck` lists the outputs that a stuck sensor repeats.
    """

    begin: int
    end: int
    path: Path
    y: Array
    stuck: tuple[int, ...] = ()

    def cut(self, stamp: int, *, whole: bool = False) -> 'Interval':
        """Return the rest after `stamp` (ns), which lies before the end; `whole` as in `after`."""
        if stamp <= self.begin:
            return self
        gone = (stamp - self.begin) / 1e9
        return self._replace(begin=stamp, path=after(self.path, gone, whole=whole))

    def since(self, origin: float) -> 'Interval':
        """Return it with the model's time counted from `origin` (s)."""
        return self._replace(path=self.path._replace(t=self.path.t - origin))


class Start(NamedTuple):
    """An estimate in numbers: state x (n,), parameters p (q,), covariance P (n + q, n + q).

    P is None where it is not known, walks (n + q,) where no process noise is. noise (r,) are the
    outputs' deviations, NaN = not known; moving (w,) are the parameters that P is about.
    """

    x: Array
    p: Array
    P: Array | None
    walks: Array | None
    noise: Array
    moving: IntArray

    @classmethod
    def of(cls, model: Model, estimate: Estimate, moving: IntArray) -> 'Start':
        """Take what a usable estimate of that model says."""
        P, size = estimate.covariance, len(model.variables)
        noise = [estimate.noise.get(name, np.nan) for name in names(model.outputs)]
        walks = [estimate.walks.get(name, 0.0) for name in names(model.variables)]
        return cls(
            np.array(list(estimate.state.values()), dtype=np.float64),
            np.array(list(estimate.parameters.values()), dtype=np.float64),
            P if P.shape == (size, size) and np.isfinite(P).all() else None,
            np.array(walks) if estimate.walks else None,
            np.array(noise),
            moving,
        )


class Carried(NamedTuple):
    """The state x (n,) at the newest output, with its variances (n,), and that output's innovation.

    The innovation (r,) is the output measured less that predicted, of variance S (r,). NaN = not
    measured, or not known.
    """

    x: Array
    variances: Array
    innovation: Array
    S: Array


class Propagation(Protocol):
    """Goes on from a start, interval by interval."""

    def advance(self, intervals: Sequence[Interval]) -> None:
        """Go on through intervals that follow one another."""

    def report(self) -> Carried:
        """Tell where the last interval ended."""


def propagation(
    model: Model,
    backend: Backend | None,
    start: Start,
    gate: InnovationGateSettings = INNOVATION_GATE,
) -> Propagation:
    """Return the filter where process noise, noise and covariance are known, else the rollout.

    The filter is corrected by what passes the gate.
    """
    noisy = np.isfinite(start.noise) & (start.noise > 0.0)
    if start.P is None or start.walks is None or not noisy.all():
        return Rollout(model, backend, start)
    return Filter(model, backend, start, start.P, start.walks, gate)


class Rollout:
    """The model alone: x in lane 0, and x off in one variable of the start in the others."""

    def __init__(self, model: Model, backend: Backend | None, start: Start) -> None:
        n = start.x.size
        stddev = None if start.P is None else np.sqrt(np.maximum(start.P.diagonal()[:n], 0.0))
        self._stepper = live_stepper(model, backend, start.noise, stddev)
        self._outputs = model.outputs
        self._noise = start.noise**2
        self._period = periods(model.outputs)
        self._last: Interval | None = None
        index = np.append(np.arange(n), n + start.moving)
        self._P = np.full((index.size, index.size), np.nan)
        if start.P is not None:
            self._P = start.P[np.ix_(index, index)]
        differences = Differences.of(model, index)
        z = np.concatenate([start.x, start.p[start.moving]])
        points, self._gaps = differences.spread(z)
        self._minus = differences.minus
        width = lanes(points.shape[1])
        self._x = np.repeat(start.x[:, None], width, axis=1)
        self._p = np.repeat(start.p[:, None], width, axis=1)
        self._y = np.empty((self._noise.size, width))
        self._x[:, : points.shape[1]] = points[:n]
        self._p[start.moving, : points.shape[1]] = points[n:]

    def advance(self, intervals: Sequence[Interval]) -> None:
        """See `Propagation`."""
        path = joined([interval.path for interval in intervals])
        self._stepper.propagate(path, self._x, self._p)
        self._last = intervals[-1]

    def report(self) -> Carried:
        """See `Propagation`."""
        x, variances = self._x[:, 0].copy(), spread(self._x, self._minus, self._gaps, self._P)
        if self._last is None:
            nothing = np.full(self._noise.size, np.nan)
            return Carried(x, variances, nothing, nothing)
        path, end = self._last.path, self._last.path.pieces
        self._stepper.measure(path.t[end], path.u[end], self._x, self._p, self._y)
        self._y[:] = nearest(self._y, self._y[:, :1], self._period[:, None])
        S = spread(self._y, self._minus, self._gaps, self._P) + self._noise
        y = contradicting(self._outputs, self._last.y, self._y[:, 0])
        return Carried(x, variances, shortest(y - self._y[:, 0], self._period), S)


class Filter:
    """An extended Kalman filter from the start on, corrected by the outputs that pass the gate."""

    def __init__(
        self,
        model: Model,
        backend: Backend | None,
        start: Start,
        P: Array,
        walks: Array,
        gate: InnovationGateSettings,
    ) -> None:
        self._stepper, self._outputs = live_stepper(model, backend, start.noise), model.outputs
        self._live = LiveFilter.of(
            model, start.x, start.p, P, walks, start.noise, start.moving
        )  # fmt: skip
        self._y = np.empty(start.noise.size)
        self._gate = Gate.of(start.noise.size, gate.limit, gate.patience)

    def advance(self, intervals: Sequence[Interval]) -> None:
        """See `Propagation`."""
        for interval in intervals:
            # Compiled steps know a saturated sensor by the very end of its range.
            ends = ends_of(self._outputs, interval.y)
            self._y[:] = interval.y if ends is None else ends.measured(interval.y)
            for i in interval.stuck:
                self._y[i] = np.nan
            self._correct(interval.path)

    def _correct(self, path: Path) -> None:
        """Go along a path, and be corrected there by the outputs that pass the gate.

        The innovation that is told is also that of an output which the gate rejects.
        """
        live = self._live
        before = live.x.copy(), live.p.copy(), live.P.copy()
        self._stepper.filter(live, path, self._y)
        rejected = self._rejected()
        if rejected.any():
            told = live.innovation.copy(), live.S.copy()
            live.x[:], live.p[:], live.P[:] = before
            self._y[rejected] = np.nan
            self._stepper.filter(live, path, self._y)
            live.innovation[:], live.S[:] = told

    def _rejected(self) -> BoolArray:
        """Return which outputs (r,) the gate rejects, by the innovations of the newest ones."""
        sizes = np.abs(self._live.innovation) / np.sqrt(self._live.S)
        verdicts = [judged(self._gate, i, size) for i, size in enumerate(sizes.tolist())]
        return np.asarray(np.equal(verdicts, REJECTED))

    def report(self) -> Carried:
        """See `Propagation`."""
        live = self._live
        return Carried(live.x, live.P.diagonal()[: live.x.size], live.innovation, live.S)


def spread_on_arrays(rows: Array, minus: IntArray, gaps: Array, P: Array) -> Array:
    """Return variances by derivatives, all at once."""
    G = (rows[:, 1 : 1 + gaps.size] - rows[:, minus]) / gaps
    return np.asarray(((G @ P) * G).sum(axis=1))


def _spread(rows: Array, minus: IntArray, gaps: Array, P: Array) -> Array:
    """Return the variances (k,) of values whose candidates are rows (k, lanes).

    Lane 1 + j is off by gaps[j] (d,) from lane minus[j] in the variable j, of covariance P (d, d).
    """
    d = gaps.size
    G, variances = np.empty(d), np.zeros(len(rows))
    for i in range(len(rows)):
        for j in range(d):
            G[j] = (rows[i, 1 + j] - rows[i, minus[j]]) / gaps[j]
        for j in range(d):
            for k in range(d):
                variances[i] += G[j] * P[j, k] * G[k]
    return variances


spread = accelerated(_spread, spread_on_arrays)


def prepare(model: Model, backend: Backend | None, moving: IntArray | None) -> None:
    """Compile the rollout, and with parameters `moving` (w,) the filter, unless they are."""
    x, p = (np.array([inside(v) for v in group]) for group in (model.states, model.parameters))
    size, y = len(model.variables), np.zeros(len(model.outputs))
    start = Start(x, p, np.eye(size), None, y, np.arange(p.size))
    Rollout(model, backend, start).report()
    for stepper in live_steps.prepare(model, backend):
        if moving is not None:
            live = LiveFilter.of(model, x, p, np.eye(size), np.ones(size), y + 1.0, moving)
            stepper.filter(live, tiny_path(model), y)
