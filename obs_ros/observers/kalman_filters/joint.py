"""Kalman filters on states and parameters together: noises, bounds, covariance, candidates.

The joint state z = (x, theta) has the n states, then the estimated parameters, D in all:

    x' = f(x, u, theta) + w,   theta' = w_theta,   (w, w_theta) ~ N(0, Q)
    y = h(x, u, theta) + v,    v ~ N(0, R)

with Q and R diagonal (Ljung 1979). C is the covariance of z. The candidates that a filter
propagates, perturbed means or sigma points, lie in lanes.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np

from obs_ros.core.jit import accelerated, bound
from obs_ros.core.model import Model, inside
from obs_ros.core.typing import Array, IntArray
from obs_ros.inference.parameterisation import Unknowns
from obs_ros.integration.path import Path, lanes
from obs_ros.observers import settings as table
from obs_ros.observers.recursive import Instant, RecursiveObserver
from obs_ros.observers.settings import setting

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


class Kernels(NamedTuple):
    """The steps of a filter on its workspace; each lays the candidates out anew.

    False stands for a covariance that is none any more.
    """

    spread: Callable[[Any], bool]  # about mean and covariance
    predict: Callable[[Any, float], bool]  # take both from the candidates, some s later
    update: Callable[[Any, Array], bool]  # correct by outputs y (r,), and write the estimate


@dataclass(frozen=True)
class KalmanSettings(table.Settings):
    """Standard deviations, as shares of the box that a state or parameter lies in."""

    initial_state: float = setting(
        0.3, "sd of the states at the start, as a share of their bounds' distance", lower=0.0,
        upper=1e3,
    )  # fmt: skip
    initial_parameter: float = setting(
        0.3, "sd of the parameters at the start, as a share of their bounds' distance", lower=0.0,
        upper=1e3,
    )  # fmt: skip
    state_walk: float = setting(
        1e-4, "sd that the model may err by within 1 s, as a share of the states' bounds' distance",
        '1/sqrt(s)', lower=0.0, upper=1e3,
    )  # fmt: skip
    parameter_walk: float = setting(
        1e-3, "sd that the parameters drift by within 1 s, as a share of their bounds' distance",
        '1/sqrt(s)', lower=0.0, upper=1e3,
    )  # fmt: skip
    output_noise: float = setting(
        1e-3, 'sd of outputs whose noise is not given, as a share of the range that they have',
        positive=True, upper=1e3,
    )  # fmt: skip


class KalmanObserver(RecursiveObserver):
    """A Kalman filter on (x, theta), nonlinear by way of the candidates in its lanes.

    The mean is clipped to the bounds, with the covariance left as it is: clipping says nothing
    about the others. No variance exceeds that of the box. Where the covariance ceases to be one,
    for rounding or overflow, it is that of the start again, counted as `reset_covariance`.

    The figure `normalised_innovation` is the mean over the measured outputs of their squared
    innovations in units of what C and R let expect: 1 on average where these are right.
    """

    Settings: ClassVar[type[table.Settings]] = KalmanSettings
    reasons: ClassVar[tuple[str, ...]] = ('reset_covariance',)

    @np.errstate(over='ignore')  # of a box too wide to be squared nothing is known at first
    def __init__(self, model: Model | str, **arguments: Any) -> None:
        super().__init__(model, **arguments)
        unknowns, n, q = self.unknowns, self.x.size, self.p.size
        free = [i - n for i in unknowns.index if i >= n]
        joint = np.array([*range(n), *(n + row for row in free)])
        low, high = self.lower[joint], self.upper[joint]
        self._width = width = np.array([_width(unknowns, i) for i in joint])
        states, s = joint < n, self.settings
        start = np.where(states, s.initial_state, s.initial_parameter) * width
        start *= np.isin(joint, unknowns.index)
        self._start_variance = start**2  # (D,)
        bounded = np.isfinite(low) & np.isfinite(high)
        d, r = joint.size, self.innovation.size
        count = lanes(1 + 2 * d)  # the mean, and two for each joint state
        self.joint = Joint(
            z=np.empty(d),
            covariance=np.empty((d, d)),
            walk=(np.where(states, s.state_walk, s.parameter_walk) * width) ** 2,
            noise=output_noise(unknowns, self.noise, s.output_noise) ** 2,
            low=low,
            high=high,
            most=np.where(bounded, np.maximum(width, start) ** 2, np.inf),
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
        self._stepper.propagate(path, self.joint.xs, self.joint.ps)
        if not self._predict(self.workspace, (now.stamp - before.stamp) / 1e9):
            self._restart_covariance(now)
        self._correct(now)

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


def output_noise(
    unknowns: Unknowns, noise: dict[str, float], share: float, points: int = 64
) -> Array:
    """Return standard deviations (r,): those given, else a share of each output's range.

    That is the distance of its bounds where they are finite, else the one over so many random
    points of the box.
    """
    model = unknowns.model
    x, p = unknowns.values(np.random.default_rng(0).random((points, unknowns.dimension)))
    u = tuple(inside(variable) for variable in model.inputs)
    with np.errstate(all='ignore'):
        outputs = model.output(0.0, tuple(x), u, tuple(p))
    deviations = []
    for variable, y in zip(model.outputs, outputs, strict=True):
        span = variable.upper - variable.lower
        if not math.isfinite(span):
            with np.errstate(all='ignore'):
                span = float(np.ptp(y))
        known = math.isfinite(span) and span > 0.0
        deviations.append(noise.get(variable.name, share * span if known else share))
    return np.array(deviations)


def _width(unknowns: Unknowns, i: int) -> float:
    """Return the width of the box of the model's unknown i, for one not estimated its bounds'."""
    at = np.flatnonzero(unknowns.index == i)
    if at.size:
        return float(unknowns.scale.width[at[0]])
    variable = unknowns.model.variables[i]
    width = variable.upper - variable.lower
    return width if math.isfinite(width) else max(1.0, abs(variable.nominal or 0.0))


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
