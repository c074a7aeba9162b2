"""H-infinity adaptive observer: Alvarado-Méndez et al. 2024, eq. 4, and a filtered regressor."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from obs_ros.core.jit import accelerated
from obs_ros.core.model import Model, inside, names
from obs_ros.core.typing import Array
from obs_ros.integration.path import Path, lanes
from obs_ros.observers.papers.adaptive_gains import GAINS
from obs_ros.observers.recursive import Instant, RecursiveObserver
from obs_ros.observers.settings import Settings, setting

DIFFERENCE = 6e-6  # of a state's or the parameter's range, for derivatives


@dataclass(frozen=True)
class HInfinitySettings(Settings):
    """Settings of the H-infinity adaptive observer."""

    adaptation: str = setting(
        'filtered', "filtered regressor, or the paper's gradient", choices=('filtered', 'gradient')
    )
    gains: str = setting(
        'designed', 'gains stored for the model: designed here, or as the paper prints them',
        choices=('designed', 'printed'),
    )  # fmt: skip
    scale: float = setting(
        1e5, 'size of the parameter: Gamma, covariance and forgetting are for theta / scale',
        'of theta', positive=True, upper=1e12,
    )  # fmt: skip
    gamma: float = setting(125.0, 'Gamma, gain of the gradient', positive=True, upper=1e12)
    forgetting: float = setting(
        0.05, 'rate at which the filtered regressor forgets', '1/s', lower=0.0, upper=1e6
    )
    covariance: float = setting(
        1e9,
        'largest covariance of the filtered regressor, and its first',
        positive=True,
        upper=1e18,
    )


class HInfinityObserver(RecursiveObserver):
    """States by a fixed gain, one parameter by adaptation.

        xhat' = f(xhat, u, theta) + L e,   e = y - C xhat

    `gradient` (eq. 4, theta = scale q):  q' = Gamma phi2(xhat, u) H e. The paper takes theta in
    N/m, which with its Gamma moves kt by 0.01 N/m in 65 s. Its theorem has no solution for the
    suspension, so nothing vouches for this law there.

    `filtered`: U' = (J - L C) U + B phi2, q' = P (C U)' e, P' = forgetting P - P^2 |C U|^2 up to
    `covariance`, with J the derivative of f and U q' added to xhat'. This converges where C U is
    persistently exciting, whatever L makes A - L C stable.

    theta stays within its bounds, states within ten times their range; the other parameters are
    what they are held at. Derivatives are differences along each step; outputs must be linear in
    the states. Steps are the model's `max_step` at most, y a straight line between outputs; one
    that is missing corrects nothing.

    `figures` holds `excitation`, |C U| in outputs per scale of theta, and `covariance`.

    Raises ValueError for a model without gains in `adaptive_gains.GAINS`, for gains of the wrong
    size, and when `parameters` names anything but the one that is adapted.
    """

    Settings = HInfinitySettings

    def __init__(self, model: Model | str, **arguments: Any) -> None:
        super().__init__(model, **arguments)
        n, r = len(self.model.states), len(self.model.outputs)
        stored = GAINS[self.model.name]
        self._adapted = self._index_of(stored.parameter)
        self._L = _sized('L', stored.L[self.settings.gains], (n, r))
        self._H, self._B = (
            _sized('H', stored.H[self.settings.gains], (r,)),
            _sized('B', stored.B, (n,)),
        )
        self._C = self._output_matrix()
        count = lanes(1 + 2 * (n + 1))
        self._x, self._p = np.zeros((n, count)), np.zeros((self.p.size, count))
        j = n + self._adapted
        width = np.concatenate(
            [self.upper[:n] - self.lower[:n], self.upper[j : j + 1] - self.lower[j : j + 1]]
        )
        self._differences = DIFFERENCE * width
        self._reach = self.lower.copy(), self.upper.copy()
        self._reach[0][:n] -= 4.5 * width[:n]
        self._reach[1][:n] += 4.5 * width[:n]
        self._y = np.zeros((r, count))
        self._U, self._P = np.zeros(n), np.zeros(1)

    @classmethod
    def suits(cls, model: Model) -> None:
        if model.name not in GAINS:
            raise ValueError(
                f'no H-infinity gains are stored for model {model.name!r}, but for '
                f'{", ".join(GAINS)}: add some to obs_ros.observers.papers.adaptive_gains.GAINS'
            )

    def _index_of(self, parameter: str) -> int:
        """Return the place of the adapted parameter among all parameters."""
        given = self._arguments['parameters']
        if given is not None and tuple(given) != (parameter,):
            raise ValueError(
                f'HInfinityObserver adapts {parameter} of {self.model.name}, not {given}'
            )
        return names(self.model.parameters).index(parameter)

    def _output_matrix(self) -> Array:
        """Return C (r, n), the outputs' change with each state."""
        u, p = (tuple(inside(v) for v in g) for g in (self.model.inputs, self.model.parameters))
        rest = np.array([inside(v) for v in self.model.states])
        columns = []
        for i in range(rest.size):
            ends = []
            for step in (-1.0, 1.0):
                x = rest.copy()
                x[i] += step
                ends.append(np.array(self.model.output(0.0, tuple(x), u, p)))
            columns.append(0.5 * (ends[1] - ends[0]))
        return np.ascontiguousarray(np.array(columns).T)

    def _start(self, now: Instant) -> None:
        self._U[:] = 0.0
        self._P[:] = self.settings.covariance
        self._innovate(now)

    def _step(self, before: Instant, now: Instant, path: Path) -> None:
        s = self.settings
        begin = np.where(np.isnan(before.y), now.y, before.y)
        slope = (np.where(np.isnan(now.y), begin, now.y) - begin) / path.dt[: path.pieces].sum()
        elapsed = 0.0
        for piece in self._pieces(path):
            t, dt, u = piece.t[0], piece.dt[0], piece.u[0]
            place(self.x, self.p, self._adapted, self._differences, self._x, self._p)
            self.stepper.measure(t, u, self._x, self._p, self._y)
            e = begin + elapsed * slope - self._y[:, 0]
            self.stepper.propagate(piece, self._x, self._p)
            adapt(
                self.x, self.p, self._adapted, self._U, self._P, e, dt, self._x,
                self._differences, self._L, self._H, self._B, self._C, s.adaptation == 'filtered',
                s.scale, s.gamma, s.forgetting, s.covariance, *self._reach,
            )  # fmt: skip
            elapsed += dt
        self._innovate(now)

    def _pieces(self, path: Path) -> list[Path]:
        """Return the path in pieces of one integration step each."""
        if path.pieces == 1 and path.steps[0] == 1:
            return [path]
        pieces, one = [], np.ones(1, dtype=np.int64)
        for k in range(path.pieces):
            h = path.dt[k] / path.steps[k]
            for i in range(path.steps[k]):
                u = path.u[k] + np.array([[i], [i + 1]]) * h * path.slope[k]
                t = path.t[k] + h * np.array([i, i + 1.0])
                pieces.append(Path(1, t, np.full(1, h), one, u, path.slope[k : k + 1].copy()))
        return pieces

    def _innovate(self, now: Instant) -> None:
        place(self.x, self.p, self._adapted, self._differences, self._x, self._p)
        self.stepper.measure(now.t, now.u, self._x, self._p, self._y)
        self.innovation[:] = now.y - self._y[:, 0]
        if self.settings.adaptation == 'filtered':
            self.figures['excitation'] = float(np.linalg.norm(self._C @ self._U))
            self.figures['covariance'] = float(self._P[0])


@accelerated
def place(x: Array, p: Array, j: int, difference: Array, xs: Array, ps: Array) -> None:
    """Lay out x and p in lane 0 and, with one entry of (x, p_j) moved both ways, in the next."""
    n = x.size
    for lane in range(xs.shape[1]):
        for i in range(n):
            xs[i, lane] = x[i]
        for i in range(p.size):
            ps[i, lane] = p[i]
    for i in range(n):
        xs[i, 1 + 2 * i] += difference[i]
        xs[i, 2 + 2 * i] -= difference[i]
    ps[j, 1 + 2 * n] += difference[n]
    ps[j, 2 + 2 * n] -= difference[n]


@accelerated
def adapt(
    x: Array, p: Array, j: int, U: Array, P: Array, e: Array, dt: float, xs: Array,
    difference: Array, L: Array, H: Array, B: Array, C: Array, filtered: bool, scale: float,
    gamma: float, forgetting: float, largest: float, lower: Array, upper: Array,
) -> None:  # fmt: skip
    """Go dt seconds on: x, p_j, U (n,) and P (1,), from candidates xs carried over it.

    e (r,) is the error at the begin, NaN where nothing was measured.
    """
    n, r = x.size, e.size
    seen = np.zeros(r)  # C U, where measured
    change = 0.0  # of theta / scale
    for i in range(r):
        if not math.isnan(e[i]):
            for k in range(n):
                seen[i] += C[i, k] * U[k]
    direct = np.empty(n)  # what a unit of theta / scale adds to x in dt
    for k in range(n):
        direct[k] = scale * (xs[k, 1 + 2 * n] - xs[k, 2 + 2 * n]) / (2.0 * difference[n])
    if filtered:
        squares = 0.0
        for i in range(r):
            squares += seen[i] * seen[i]
        # Implicit in P: the explicit step overshoots below zero when much is learnt at once.
        P[0] = min(P[0] * math.exp(forgetting * dt) / (1.0 + dt * P[0] * squares), largest)
        for i in range(r):
            if not math.isnan(e[i]):
                change += dt * P[0] * seen[i] * e[i]
    else:
        size, along = 0.0, 0.0
        for k in range(n):
            size += B[k] * B[k]
            along += B[k] * direct[k]
        for i in range(r):
            if not math.isnan(e[i]):
                change += gamma * along / size * H[i] * e[i]
    theta = min(max(p[j] + scale * change, lower[n + j]), upper[n + j])
    change = (theta - p[j]) / scale
    p[j] = theta
    carried = np.empty(n)
    for k in range(n):
        carried[k] = direct[k]
        for i in range(n):
            carried[k] += (xs[k, 1 + 2 * i] - xs[k, 2 + 2 * i]) / (2.0 * difference[i]) * U[i]
        x[k] = xs[k, 0]
        for i in range(r):
            if not math.isnan(e[i]):
                x[k] += dt * L[k, i] * e[i]
                carried[k] -= dt * L[k, i] * seen[i]
        if filtered:
            x[k] += U[k] * change
        x[k] = min(max(x[k], lower[k]), upper[k])
    for k in range(n):
        U[k] = carried[k]


def _sized(name: str, values: Any, shape: tuple[int, ...]) -> Array:
    array = np.array(values, dtype=np.float64)
    if array.size != math.prod(shape):
        raise ValueError(f'{name} has {array.size} entries: {" x ".join(map(str, shape))} needed')
    return np.ascontiguousarray(array.reshape(shape))
