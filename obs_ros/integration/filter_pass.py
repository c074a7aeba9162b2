"""The extended Kalman filter along a window: what process noise makes of one candidate.

The states, and the parameters that move within the window as states without dynamics, are z (d,):

    dz = f(t, z, u, p) dt + diag(walks) dW,    y_k = h(t_k, z_k, u_k, p) + v_k,  v_k ~ N(0, R)

with R = diag(noise^2) and Q = diag(walks^2). From node to node, dt apart, with F = dz_k / dz_(k-1)
(Jazwinski 1970, section 8.3; the noise that an interval adds by Simpson's rule, with (I + F) / 2
for the transition from its middle to its end, which is exact for a double integrator):

    z <- rollout of z,    P <- F P F' + dt/6 (Q + (I + F) Q (I + F)' + F Q F')

(of a discrete model, whose nodes are dt apart, noise enters at each node: P <- F P F' + dt Q),
and for one measured output i after the other (Anderson & Moore 1979, section 6.4), with h and
C = dh/dz evaluated once, at the prediction:

    S_i = C_i P C_i' + R_i,    K_i = P C_i' / S_i,    e_i = y_i - h_i - sum_(j < i) C_i K_j e_j
    z <- z + K_i e_i,    P <- (I - K_i C_i) P (I - K_i C_i)' + K_i R_i K_i'
"""

import functools
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from obs_ros.core.model import Model, inside
from obs_ros.core.periods import lasting_bounds, shortest
from obs_ros.core.typing import Array, BoolArray, IntArray
from obs_ros.integration.grid import Grid, Injection
from obs_ros.integration.path import LANES

DIFFERENCE = 1e-4  # of a size: rounding stays below 1e-11, curvature matters to no gain
SMALLEST_SIZE = 0.1  # of the box: the size of a variable that passes through 0


@dataclass(frozen=True)
class FilterPass:
    """A filter's way along the K nodes of a window.

    Between nodes lie dt (K - 1,) s. z holds the variables index (d,) of the n states and q
    parameters: the states, then the parameters `moving` (w,). measured (K, r) says which outputs
    were. gain (K, r, n + q), cross (K, r, r) with the entries C_i K_j, and the variances S (K, r)
    of the innovations (K, r) are as above; where nothing was measured gains and cross are 0, S and
    innovations NaN. transition (K - 1, n, d) are the states' rows of F,
    sensitivity (K, r, d) is C. means (K, d) and covariances (K, d, d) are those of z after the
    updates at each node, prior (d, d) is the covariance before the first; given (q,) are the
    parameters at the start. An output at or beyond the end that its saturated sensor shows is
    taken as not measured, but for S and sensitivity. `discrete` says what kind the model is.
    """

    dt: Array
    index: IntArray
    given: Array
    prior: Array
    measured: BoolArray
    transition: Array
    sensitivity: Array
    gain: Array
    cross: Array
    S: Array
    innovations: Array
    means: Array
    covariances: Array
    discrete: bool = False

    @classmethod
    def blank(
        cls, grid: Grid, x0: Array, p: Array, walks: Array, P0: Array | None,
        moving: IntArray | None,
    ) -> 'FilterPass':  # fmt: skip
        """Lay out a pass for a backend to fill in; zeros and NaN stand where nothing is measured.

        `moving` None means the parameters that walk or are uncertain at the start.
        """
        n, size, nodes, r = x0.size, x0.size + p.size, grid.t.size, grid.y.shape[1]
        if moving is None:
            moves = walks[n:] > 0.0 if P0 is None else (walks[n:] > 0.0) | (P0.diagonal()[n:] > 0.0)
            moving = np.flatnonzero(moves)
        index = np.append(np.arange(n), n + moving)
        d = index.size
        prior = np.zeros((d, d)) if P0 is None else P0[np.ix_(index, index)]
        return cls(
            dt=np.diff(grid.t),
            index=index,
            given=np.ascontiguousarray(p),
            prior=np.ascontiguousarray(prior),
            measured=grid.weight > 0.0,
            transition=np.empty((nodes - 1, n, d)),
            sensitivity=np.zeros((nodes, r, d)),
            gain=np.zeros((nodes, r, size)),
            cross=np.zeros((nodes, r, r)),
            S=np.full((nodes, r), np.nan),
            innovations=np.full((nodes, r), np.nan),
            means=np.empty((nodes, d)),
            covariances=np.empty((nodes, d, d)),
            discrete=grid.discrete,
        )

    @property
    def moving(self) -> IntArray:
        """Indices (w,) of the parameters that move."""
        n = self.transition.shape[1]
        return np.asarray(self.index[n:] - n)

    @property
    def injection(self) -> Injection:
        """The gains, frozen: `grid.injected(found.injection, found.S)` corrects every rollout."""
        return Injection(self.gain, self.cross, self.moving)

    @property
    def neg2_log_likelihood(self) -> float:
        """-2 log p(y) but for a constant: sum of log S + e^2 / S; infinite after divergence."""
        with np.errstate(all='ignore'):
            terms = np.log(self.S) + self.innovations**2 / self.S
        total = float(np.sum(terms, where=self.measured))
        return total if np.isfinite(total) else np.inf

    @property
    def states(self) -> Array:
        """Filtered states (K, n)."""
        return self.means[:, : self.transition.shape[1]]

    @property
    def parameters(self) -> Array:
        """Filtered parameters (K, q): those given, except where they move."""
        parameters = np.repeat(self.given[None], len(self.means), axis=0)
        parameters[:, self.moving] = self.means[:, self.transition.shape[1] :]
        return parameters

    @property
    def P(self) -> Array:
        """Covariance (n + q, n + q) after the last node's updates; 0 for what does not move."""
        size = self.gain.shape[2]
        P = np.zeros((size, size))
        P[np.ix_(self.index, self.index)] = self.covariances[-1]
        return P


class Differences(NamedTuple):
    """Lanes whose differences make derivatives: z in lane 0, z off in one variable in the others.

    The derivative by variable j of z (d,) is that between the lanes 1 + j and minus[j], which is
    lane 0 where differences are forward. size (d,) is the smallest size of a variable, low and high
    (d,) are its bounds, which no lane leaves where z itself is within them.
    """

    minus: IntArray
    size: Array
    low: Array
    high: Array

    @classmethod
    def of(cls, model: Model, index: IntArray) -> 'Differences':
        """Lay out the lanes of the model's variables `index` (d,)."""
        d = index.size
        minus = np.arange(1 + d, 1 + 2 * d) if central(d) else np.zeros(d, np.int64)
        return cls(minus, *sizes(model)[:, index])

    @property
    def lanes(self) -> int:
        """Number of the lanes in use."""
        return 1 + max(self.minus.size, int(self.minus.max()))

    def spread(self, z: Array) -> tuple[Array, Array]:
        """Return points (d, lanes) about z (d,), and the distances (d,) of those compared."""
        points = np.repeat(z[:, None], self.lanes, axis=1)
        reach = DIFFERENCE * np.maximum(np.abs(z), self.size)
        above, below = z + reach, z - reach
        rows, both = np.arange(z.size), self.minus > 0
        inner, outer = np.fmin(self.low, z), np.fmax(self.high, z)
        plus = np.where(above <= outer, above, np.where(both, outer, below))
        points[rows, 1 + rows] = plus
        minus = np.where(both, np.fmax(below, inner), z)
        points[rows, self.minus] = minus
        return points, plus - minus


def central(d: int) -> bool:
    """Whether differences by d variables are central: in the first chunk their lanes are free."""
    return 1 + 2 * d <= LANES


@functools.lru_cache(maxsize=64)
def sizes(model: Model) -> Array:
    """Return smallest sizes, lower and upper bounds (3, n + q) of the model's variables."""
    smallest = [
        0.0 if v.scale == 'log'
        else SMALLEST_SIZE * v.period if v.period
        else SMALLEST_SIZE * (v.upper - v.lower) if np.isfinite(v.upper - v.lower)
        else SMALLEST_SIZE * (abs(inside(v)) or 1.0)
        for v in model.variables
    ]  # fmt: skip
    return np.array([smallest, *np.transpose([lasting_bounds(v) for v in model.variables])])


def predicted(F: Array, dt: float, Q: Array, P: Array, *, discrete: bool) -> Array:
    """Return the covariance (d, d) at the end of an interval of dt s, from P at its begin."""
    if discrete:
        return np.asarray(F @ P @ F.T + dt * Q)
    half = np.eye(len(F)) + F
    noises = Q + half @ Q @ half.T + F @ Q @ F.T
    return np.asarray(F @ P @ F.T + dt / 6.0 * noises)


def beyond(grid: Grid, k: int, i: int, output: float) -> bool:
    """Whether an output is at or beyond the end that its saturated sensor shows at node k."""
    ends = grid.ends
    return ends is not None and bool(output <= ends.low[k, i] or output >= ends.high[k, i])


Advance = Callable[[int, Any, Any], Any]  # k, states, parameters: the states at node k + 1


def run(
    found: FilterPass, model: Model, grid: Grid, advance: Advance, x0: Array, walks: Array,
    noise: Array,
) -> None:  # fmt: skip
    """Fill in the pass by the textbook's formulas: the oracle of the compiled one."""
    n, d = x0.size, found.prior.shape[0]
    differences = Differences.of(model, found.index)
    Q, unit, P = np.diag(walks[found.index] ** 2), np.eye(d), found.prior
    z = np.concatenate([x0, found.given[found.moving]])

    def lanes_about(z: Array) -> tuple[Any, Any, Array]:
        points, gaps = differences.spread(z)
        p = np.repeat(found.given[:, None], points.shape[1], axis=1)
        p[found.moving] = points[n:]
        return tuple(points[:n]), tuple(p), gaps

    def derivatives(values: Any, gaps: Array, period: Any = 0.0) -> tuple[Array, Array]:
        rows = np.array([np.broadcast_to(row, differences.lanes) for row in values])
        return rows[:, 0], shortest(rows[:, 1 : 1 + d] - rows[:, differences.minus], period) / gaps

    for k in range(grid.t.size):
        if k > 0:
            x, p, gaps = lanes_about(z)
            z = z.copy()
            z[:n], found.transition[k - 1] = derivatives(advance(k - 1, x, p), gaps)
            F = np.concatenate([found.transition[k - 1], unit[n:]])
            P = predicted(F, found.dt[k - 1], Q, P, discrete=found.discrete)
        if grid.measured[k]:
            x, p, gaps = lanes_about(z)
            y = model.output(grid.clock[k], x, tuple(grid.u[k]), p)
            h, C = derivatives(y, gaps, grid.period[:, None])
            e = np.zeros(h.size)
            for i in np.flatnonzero(found.measured[k]):
                found.sensitivity[k, i] = C[i]
                S = found.S[k, i] = C[i] @ P @ C[i] + noise[i] ** 2
                K = P @ C[i] / S
                expected = h[i] + found.cross[k, i] @ e
                if beyond(grid, k, int(i), expected):
                    found.measured[k, i] = False
                    continue
                e[i] = grid.y[k, i] - expected
                e = shortest(e, grid.period)
                z = z + K * e[i]
                J = unit - np.outer(K, C[i])
                P = J @ P @ J.T + noise[i] ** 2 * np.outer(K, K)
                found.gain[k, i, found.index] = K
                found.innovations[k, i] = e[i]
                for later in np.flatnonzero(found.measured[k, i + 1 :]) + i + 1:
                    found.cross[k, later, i] = C[later] @ K
        P = 0.5 * (P + P.T)
        found.means[k], found.covariances[k] = z, P
