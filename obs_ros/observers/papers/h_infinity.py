"""H-infinity adaptive observer: Alvarado-Méndez et al. 2024, eq. 4, and a filtered regressor."""

import math
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np

from obs_ros.core.jit import accelerated, bound
from obs_ros.core.model import Model, inside, names
from obs_ros.core.typing import Array
from obs_ros.integration.path import Path, lanes
from obs_ros.observers.output_intake import Instant
from obs_ros.observers.papers.adaptive_gains import GAINS
from obs_ros.observers.recursive import RecursiveObserver
from obs_ros.observers.settings import Settings, setting


class Workspace(NamedTuple):
    """The arrays of the observer: n states, q parameters, r outputs."""

    x: Array  # (n,) the estimate, where all read it
    p: Array  # (q,)
    U: Array  # (n,) filtered regressor: d x / d q
    P: Array  # (1,) its covariance
    adapted: int  # place of theta among the parameters
    L: Array  # (n, r) gains
    H: Array  # (r,)
    B: Array  # (n,) model
    C: Array  # (r, n)
    lower: Array  # (n + q,) least values that the observer lets x and p have
    upper: Array  # (n + q,)
    differences: Array  # (n + 1,) steps of the states and of theta, for derivatives
    xs: Array  # (n, lanes) candidates: states,
    ps: Array  # (q, lanes) parameters
    ys: Array  # (r, lanes) and outputs
    filtered: bool  # the settings
    scale: float
    gamma: float
    forgetting: float
    covariance: float


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
        1e9, 'largest covariance of the filtered regressor, and its first', positive=True,
        upper=1e18,
    )  # fmt: skip


class HInfinityObserver(RecursiveObserver):
    """States by a fixed gain, one parameter by adaptation.

        x' = A x + Psi(x, u) + B phi2(x, u) theta + N eta,   y = C x
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
    size, and when `parameters` names anything but the one that is adapted, or `fixed` names that.
    """

    Settings = HInfinitySettings
    beyond: ClassVar[float] = 4.5  # ranges beyond its bounds that a state may go, on each side

    def __init__(self, model: Model | str, **arguments: Any) -> None:
        super().__init__(model, **arguments)
        n, r = len(self.model.states), len(self.model.outputs)
        stored = GAINS[self.model.name]
        s, adapted = self.settings, self._index_of(stored.parameter)
        width = (self.upper - self.lower)[[*range(n), n + adapted]]
        lower, upper = self.lower.copy(), self.upper.copy()
        lower[:n] -= self.beyond * width[:n]
        upper[:n] += self.beyond * width[:n]
        count = lanes(1 + 2 * (n + 1))
        self.workspace = Workspace(
            x=self.x,
            p=self.p,
            U=np.zeros(n),
            P=np.zeros(1),
            adapted=adapted,
            L=_sized('L', stored.L[s.gains], (n, r)),
            H=_sized('H', stored.H[s.gains], (r,)),
            B=_sized('B', stored.B, (n,)),
            C=self._output_matrix(),
            lower=lower,
            upper=upper,
            differences=self.difference * width,
            xs=np.zeros((n, count)),
            ps=np.zeros((self.p.size, count)),
            ys=np.zeros((r, count)),
            filtered=s.adaptation == 'filtered',
            scale=s.scale,
            gamma=s.gamma,
            forgetting=s.forgetting,
            covariance=s.covariance,
        )

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
        if parameter in (self._arguments['fixed'] or {}):
            raise ValueError(f'leave {parameter} free: HInfinityObserver adapts it')
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
        w, self._stepper = self.workspace, self.stepper
        self._place, self._adapt = bound(place, w), bound(adapt, w, now.y, 0.0)
        w.U[:] = 0.0
        w.P[:] = self.settings.covariance
        self._innovate(now)

    def _step(self, before: Instant, now: Instant, path: Path) -> None:
        w = self.workspace
        begin = np.where(np.isnan(before.y), now.y, before.y)
        slope = (np.where(np.isnan(now.y), begin, now.y) - begin) / path.dt[: path.pieces].sum()
        elapsed = 0.0
        for piece in self._pieces(path):
            self._place(w)
            self._stepper.measure(piece.t[0], piece.u[0], w.xs, w.ps, w.ys)
            e = begin + elapsed * slope - w.ys[:, 0]
            self._stepper.propagate(piece, w.xs, w.ps)
            self._adapt(w, e, piece.dt[0])
            elapsed += piece.dt[0]
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
        w = self.workspace
        self._place(w)
        self._stepper.measure(now.t, now.u, w.xs, w.ps, w.ys)
        self.innovation[:] = now.y - w.ys[:, 0]
        if w.filtered:
            self.figures['excitation'] = float(np.linalg.norm(w.C @ w.U))
            self.figures['covariance'] = float(w.P[0])


@accelerated
def place(w: Workspace) -> None:
    """Lay out x and p in lane 0 and, with one entry of (x, theta) moved both ways, in the next."""
    x, p, xs, ps, differences = w.x, w.p, w.xs, w.ps, w.differences
    n = x.size
    for lane in range(xs.shape[1]):
        for i in range(n):
            xs[i, lane] = x[i]
        for i in range(p.size):
            ps[i, lane] = p[i]
    for i in range(n):
        xs[i, 1 + 2 * i] += differences[i]
        xs[i, 2 + 2 * i] -= differences[i]
    ps[w.adapted, 1 + 2 * n] += differences[n]
    ps[w.adapted, 2 + 2 * n] -= differences[n]


@accelerated
def adapt(w: Workspace, e: Array, dt: float) -> None:
    """Go dt seconds on, from candidates propagated over them: x, theta, U and P.

    e (r,) is the error at the begin, NaN where nothing was measured.
    """
    x, p, U, L, C, xs, differences = w.x, w.p, w.U, w.L, w.C, w.xs, w.differences
    lower, upper, filtered, scale, n = w.lower, w.upper, w.filtered, w.scale, w.x.size
    seen = np.zeros(e.size)  # C U, where measured
    for i in range(e.size):
        if not math.isnan(e[i]):
            for k in range(n):
                seen[i] += C[i, k] * U[k]
    direct = np.empty(n)  # effect of a unit of theta / scale on x in dt
    for k in range(n):
        difference = xs[k, 1 + 2 * n] - xs[k, 2 + 2 * n]
        direct[k] = scale * difference / (2.0 * differences[n])
    theta, j = p[w.adapted], n + w.adapted
    change = filtered_change(w, seen, e, dt) if filtered else gradient_change(w, direct, e)
    p[w.adapted] = min(max(theta + scale * change, lower[j]), upper[j])
    change = (p[w.adapted] - theta) / scale
    moved = np.empty(n)  # U, dt later
    for k in range(n):
        moved[k] = direct[k]
        for i in range(n):
            difference = xs[k, 1 + 2 * i] - xs[k, 2 + 2 * i]
            moved[k] += difference / (2.0 * differences[i]) * U[i]
        x[k] = xs[k, 0]
        for i in range(e.size):
            if not math.isnan(e[i]):
                x[k] += dt * L[k, i] * e[i]
                moved[k] -= dt * L[k, i] * seen[i]
        if filtered:
            x[k] += U[k] * change
        x[k] = min(max(x[k], lower[k]), upper[k])
    for k in range(n):
        U[k] = moved[k]


@accelerated
def filtered_change(w: Workspace, seen: Array, e: Array, dt: float) -> float:
    """Return the change of theta / scale in dt s by the filtered regressor; P goes on."""
    P, squares, change = w.P, 0.0, 0.0
    for i in range(e.size):
        squares += seen[i] * seen[i]
    # Implicit in P: the explicit step overshoots below zero when much is learnt at once.
    grown = P[0] * math.exp(w.forgetting * dt)
    P[0] = min(grown / (1.0 + dt * P[0] * squares), w.covariance)
    for i in range(e.size):
        if not math.isnan(e[i]):
            change += dt * P[0] * seen[i] * e[i]
    return change


@accelerated
def gradient_change(w: Workspace, direct: Array, e: Array) -> float:
    """Return the change of theta / scale by the paper's gradient; phi2 from its effect on x."""
    B, size, along, change = w.B, 0.0, 0.0, 0.0
    for k in range(B.size):
        size += B[k] * B[k]
        along += B[k] * direct[k]
    for i in range(e.size):
        if not math.isnan(e[i]):
            change += w.gamma * along / size * w.H[i] * e[i]
    return change


def _sized(name: str, values: Any, shape: tuple[int, ...]) -> Array:
    array = np.array(values, dtype=np.float64)
    if array.size != math.prod(shape):
        raise ValueError(f'{name} has {array.size} entries: {" x ".join(map(str, shape))} needed')
    return np.ascontiguousarray(array.reshape(shape))
