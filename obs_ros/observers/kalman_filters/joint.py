"""Kalman filters on states and parameters together: noises, bounds, covariance, candidates.

The joint state z = (x, theta) has the n states, then the estimated parameters, D in all:

    x' = f(x, u, theta) + w,   theta' = w_theta,   (w, w_theta) ~ N(0, Q)
    y = h(x, u, theta) + v,    v ~ N(0, R)

(of a discrete model x <- f(x, u, theta) + w, of variance Q times the period, from node to node)
with Q and R diagonal (Ljung 1979). C is the covariance of z. The walk of a parameter on a log scale
is one of its logarithm: its entry of Q is (walk theta)^2, to first order in the walk. The
candidates that a filter propagates, perturbed means or sigma points, lie in lanes.
"""

import math
from collections.abc import Callable, Mapping
from typing import Any, ClassVar, NamedTuple

import numpy as np

from obs_ros.core.jit import accelerated, bound
from obs_ros.core.model import Model
from obs_ros.core.periods import periods
from obs_ros.core.prior_knowledge import with_knowledge
from obs_ros.core.typing import Array, IntArray
from obs_ros.inference.innovation_gate import Gate
from obs_ros.integration.path import Path, lanes, single
from obs_ros.models import load_model
from obs_ros.observers import settings as table
from obs_ros.observers.kalman_filters.deviations import KalmanSettings, begun, output_noise
from obs_ros.observers.output_intake import Instant
from obs_ros.observers.recursive import RecursiveObserver

SLACK = 1e-9  # of a correlation: less is rounding


class Joint(NamedTuple):
    """The arrays of a filter on D joint states: of n states, q parameters, r outputs, L lanes."""

    z: Array  # (D,) mean
    covariance: Array  # (D, D)
    walk: Array  # (D,) diagonal of Q, per s
    noise: Array  # (r,) diagonal of R
    low: Array  # (D,) bounds of the mean
    high: Array  # (D,)
    most: Array  # (D,) largest variances
    period: Array  # (r,) of the outputs, 0 for those without
    rows: IntArray  # (D - n,) places of the estimated parameters among all
    xs: Array  # (n, L) candidates: states,
    ps: Array  # (q, L) parameters
    ys: Array  # (r, L) and outputs
    x: Array  # (n,) the estimate, where all read it
    p: Array  # (q,)
    stddev: Array  # (n + q,)
    innovation: Array  # (r,)
    innovation_stddev: Array  # (r,) NaN = not measured
    surprise: Array  # (1,) mean squared innovation, in units of what C and R let expect
    gate: Gate


class Kernels(NamedTuple):
    """The steps of a filter on its workspace; each lays the candidates out anew.

    False stands for a covariance that is none any more.
    """

    spread: Callable[[Any], bool]  # about mean and covariance
    predict: Callable[[Any, float], bool]  # take both from the candidates, some s later
    update: Callable[[Any, Array], bool]  # correct by outputs y (r,), and write the estimate


class KalmanObserver(RecursiveObserver):
    """A Kalman filter on (x, theta), nonlinear by way of the candidates in its lanes.

    The mean is clipped to the bounds, with the covariance left as it is: clipping says nothing
    about the others. No variance exceeds that of the box. Where the covariance ceases to be one,
    for rounding or overflow, it is that of the start again, counted as `reset_covariance`. Where
    the gate opens after many rejections, it grows until the innovation is as expected.

    `walks` and `priors` are by name, in place of the model's; 0 and None take the model's away. A
    finite walk, and the standard deviation of a prior, count before the shares of the settings.

    The figure `normalised_innovation` is the mean over the measured outputs of their squared
    innovations in units of what C and R let expect: 1 on average where these are right.
    """

    Settings: ClassVar[type[table.Settings]] = KalmanSettings
    takes_priors: ClassVar[bool] = True
    gates_itself: ClassVar[bool] = True
    takes_discrete: ClassVar[bool] = True
    reasons: ClassVar[tuple[str, ...]] = ('reset_covariance',)

    @np.errstate(over='ignore')  # of a box too wide to be squared nothing is known at first
    def __init__(
        self,
        model: Model | str,
        *,
        walks: Mapping[str, float] | None = None,
        priors: Mapping[str, tuple[float, float] | None] | None = None,
        **arguments: Any,
    ) -> None:
        super().__init__(with_knowledge(load_model(model), walks, priors), **arguments)
        wanted = [name for name, prior in (priors or {}).items() if prior is not None]
        self.unknowns.check_estimated('a prior', wanted)
        unknowns, n, q = self.unknowns, self.x.size, self.p.size
        free = [i - n for i in unknowns.index if i >= n]
        joint = np.array([*range(n), *(n + row for row in free)])
        low, high = self.lower[joint], self.upper[joint]
        given = begun(unknowns, joint, self.settings)
        self._width = width = given.width
        self._start_variance = given.start**2  # (D,)
        self._relative, self._relative_walk = given.relative, given.walk[given.relative]
        wraps = [self.model.variables[i].period is not None for i in joint]
        bounded = (np.isfinite(low) & np.isfinite(high)) | wraps
        d, r = joint.size, self.innovation.size
        self._noise = output_noise(unknowns, self.noise, self.settings.output_noise)
        count = lanes(1 + 2 * d)  # the mean, and two for each joint state
        self.joint = Joint(
            z=np.empty(d),
            covariance=np.empty((d, d)),
            walk=given.walk**2,
            noise=self._noise**2,
            low=low,
            high=high,
            most=np.where(bounded, np.maximum(width, given.start) ** 2, np.inf),
            period=periods(self.model.outputs),
            rows=np.array(free, dtype=np.int64),
            xs=np.empty((n, count)),
            ps=np.empty((q, count)),
            ys=np.empty((r, count)),
            x=self.x,
            p=self.p,
            stddev=self.stddev,
            innovation=self.innovation,
            innovation_stddev=self.innovation_stddev,
            surprise=np.zeros(1),
            gate=self._intake.gate,
        )
        self.workspace = self._workspace()

    def _workspace(self) -> Any:
        """Return the joint state with all else that the kernels take."""
        raise NotImplementedError

    def _kernels(self) -> Kernels:
        """Return the filter's kernels."""
        raise NotImplementedError

    def _start(self, now: Instant) -> None:
        joint, n = self.joint, self.x.size
        self._stepper = self.stepper
        spread, predict, update = self._kernels()
        self._spread = bound(spread, self.workspace)
        self._predict = bound(predict, self.workspace, 0.0)
        self._update = bound(update, self.workspace, now.y)
        joint.ps[:] = self.p[:, None]
        joint.z[:n], joint.z[n:] = self.x, self.p[joint.rows]
        joint.covariance[:] = np.diag(self._start_variance)
        self._spread(self.workspace)
        self._correct(now)

    def _step(self, before: Instant, now: Instant, path: Path) -> None:
        if self.model.kind == 'discrete':
            for piece in single(path):  # noise enters at every node
                self._go_on(piece, float(piece.dt[0]), now)
        else:
            self._go_on(path, (now.stamp - before.stamp) / 1e9, now)
        self._correct(now)

    def _go_on(self, path: Path, seconds: float, now: Instant) -> None:
        """Take mean and covariance along a path of so many seconds."""
        self._stepper.propagate(path, self.joint.xs, self.joint.ps)
        if self._relative.size:
            value = self.joint.z[self._relative]
            self.joint.walk[self._relative] = (self._relative_walk * value) ** 2
        if not self._predict(self.workspace, seconds):
            self._restart_covariance(now)

    def _correct(self, now: Instant) -> None:
        joint = self.joint
        self._stepper.measure(now.t, now.u, joint.xs, joint.ps, joint.ys)
        if not self._update(self.workspace, now.y):
            self._restart_covariance(now)
        self.figures['normalised_innovation'] = float(joint.surprise[0])

    def _restart_covariance(self, now: Instant) -> None:
        self._remark_on(
            'reset_covariance',
            f'covariance started again at {now.t:g} s, because it was not positive any more',
        )
        self.joint.covariance[:] = np.diag(self._start_variance)
        self._spread(self.workspace)


@accelerated
def place(z: Array, lane: int, rows: IntArray, xs: Array, ps: Array) -> None:
    """Write a joint state z (D,) into one lane."""
    n = xs.shape[0]
    for i in range(n):
        xs[i, lane] = z[i]
    for j in range(rows.size):
        ps[rows[j], lane] = z[n + j]


@accelerated
def clip(z: Array, low: Array, high: Array) -> None:
    """Put z (D,) within its bounds."""
    for i in range(z.size):
        z[i] = min(max(z[i], low[i]), high[i])


@accelerated
def limit(c: Array, most: Array) -> None:
    """Scale rows and columns of the covariance so that no variance exceeds `most` (D,)."""
    for i in range(most.size):
        if c[i, i] > most[i]:
            factor = math.sqrt(most[i] / c[i, i])
            for j in range(most.size):
                c[i, j] *= factor
                c[j, i] *= factor


@accelerated
def widening(error: float, noise: float, spread_of_y: float) -> float:
    """Return the factor by which the covariance must grow for an innovation of one sd."""
    if not spread_of_y > 0.0:
        return 1.0
    return max(1.0, (error * error - noise) / spread_of_y)


@accelerated
def widen(c: Array, factor: float, most: Array) -> None:
    """Multiply the covariance by a factor, as far as no variance exceeds `most` (D,)."""
    if factor > 1.0 and factor < math.inf:
        for i in range(c.shape[0]):
            for j in range(c.shape[0]):
                c[i, j] *= factor
        limit(c, most)


@accelerated
def root(c: Array, lower: Array) -> bool:
    """Write into lower (D, D) the Cholesky factor of a covariance that may be singular.

    False if c is no covariance: not finite, or indefinite by more than rounding.
    """
    d = c.shape[0]
    for j in range(d):
        for i in range(j):
            lower[i, j] = 0.0
        pivot = c[j, j]
        for k in range(j):
            pivot -= lower[j, k] * lower[j, k]
        if not (pivot >= -SLACK * c[j, j] and c[j, j] < math.inf):
            return False
        lower[j, j] = math.sqrt(pivot) if pivot > 0.0 else 0.0
        for i in range(j + 1, d):
            rest = c[i, j]
            for k in range(j):
                rest -= lower[i, k] * lower[j, k]
            if lower[j, j] > 1e-8 * math.sqrt(c[j, j]):
                lower[i, j] = rest / lower[j, j]
            elif abs(rest) <= 1e-6 * math.sqrt(abs(c[i, i] * c[j, j])):
                lower[i, j] = 0.0
            else:
                return False
    return True


@accelerated
def report(joint: Joint) -> None:
    """Write states, estimated parameters and standard deviations where all read them."""
    z, c, rows = joint.z, joint.covariance, joint.rows
    x, p, stddev = joint.x, joint.p, joint.stddev
    n = x.size
    for i in range(n):
        x[i] = z[i]
        stddev[i] = math.sqrt(max(c[i, i], 0.0))
    for j in range(rows.size):
        p[rows[j]] = z[n + j]
        stddev[n + rows[j]] = math.sqrt(max(c[n + j, n + j], 0.0))
