"""The extended Kalman filter from one output to the next, for whoever follows a plant live.

Its equations are those of `filter_pass`, for variables z (d,): the states, and parameters that are
states without dynamics. Parameters without a walk are considered (Schmidt 1966): no output corrects
them, their rows of the gain being 0, but their variance enters that of the innovations, and so the
gains of the others. Joseph's form holds for every gain.
"""

from dataclasses import dataclass
from operator import itemgetter
from typing import Any, Protocol

import numpy as np

from obs_ros.core.model import Model
from obs_ros.core.periods import periods, shortest
from obs_ros.core.saturation import contradicting
from obs_ros.core.typing import Array, IntArray
from obs_ros.integration.filter_pass import Differences, predicted, sizes
from obs_ros.integration.path import Path, lanes, mapped


@dataclass(frozen=True)
class LiveFilter:
    """A filter at the newest output: x (n,), p (q,) and the covariance P (d, d) of z.

    z are the states and the parameters `moving` (w,); variances (d,) are the walks' per s, noise
    (r,) the outputs'; corrected (d,) is 0 for what no output corrects, else 1; limits (3, d) are
    smallest sizes and bounds, see `Differences`. innovation (r,) is the newest output less that
    predicted from the one before, S (r,) its variance; NaN = not measured. All change in place.
    """

    x: Array
    p: Array
    P: Array
    variances: Array
    noise: Array
    moving: IntArray
    corrected: Array
    limits: Array
    innovation: Array
    S: Array

    @classmethod
    def of(
        cls, model: Model, x: Array, p: Array, P: Array, walks: Array, noise: Array,
        moving: IntArray,
    ) -> 'LiveFilter':  # fmt: skip
        """Begin at x (n,), p (q,), of covariance P (n + q, n + q); walks (n + q,), noise (r,).

        walks are per root of a second, noise standard deviations, all in the variables' units.
        """
        n, r = x.size, noise.size
        index = np.append(np.arange(n), n + moving)
        return cls(
            x=x.copy(),
            p=p.copy(),
            P=P[np.ix_(index, index)],
            variances=walks[index] ** 2,
            noise=noise**2,
            moving=moving,
            corrected=np.where((index < n) | (walks[index] > 0.0), 1.0, 0.0),
            limits=np.ascontiguousarray(sizes(model)[:, index]),
            innovation=np.full(r, np.nan),
            S=np.full(r, np.nan),
        )


class Steps(Protocol):
    """The part of a `Stepper` that a filter needs."""

    model: Model

    def propagate(self, path: Path, x: Array, p: Array) -> None:
        """See `Stepper.propagate`."""

    def measure(self, t: float, u: Array, x: Array, p: Array, y: Array) -> None:
        """See `Stepper.measure`."""


def run_step(live: LiveFilter, steps: Steps, path: Path, y: Array) -> None:
    """Take a filter through one path by the textbook's formulas: the oracle of the compiled one.

    An output of which a saturated sensor says no more than the filter counts as not measured.
    """
    n, d = live.x.size, len(live.P)
    index = np.append(np.arange(n), n + live.moving)
    differences = Differences.of(steps.model, index)
    z, P, Q, unit = (
        np.append(live.x, live.p[live.moving]),
        live.P,
        np.diag(live.variances),
        np.eye(d),
    )

    def lanes_about(z: Array) -> tuple[Array, Array, Array]:
        points, gaps = differences.spread(z)
        fill = np.repeat(z[:, None], lanes(points.shape[1]) - points.shape[1], axis=1)
        points = np.hstack([points, fill])
        p = np.repeat(live.p[:, None], points.shape[1], axis=1)
        p[live.moving] = points[n:]
        return points[:n].copy(), p, gaps

    def derivatives(rows: Array, gaps: Array, period: Any = 0.0) -> Array:
        return shortest(rows[:, 1 : 1 + d] - rows[:, differences.minus], period) / gaps

    for k in range(path.pieces):
        x, p, gaps = lanes_about(z)
        steps.propagate(mapped(1, itemgetter(slice(k, k + 1)), path), x, p)
        z = np.append(x[:, 0], z[n:])
        F = np.vstack([derivatives(x, gaps), unit[n:]])
        P = predicted(F, path.dt[k], Q, P, discrete=steps.model.kind == 'discrete')
    x, p, gaps = lanes_about(z)
    outputs = np.empty((y.size, x.shape[1]))
    steps.measure(path.t[path.pieces], path.u[path.pieces], x, p, outputs)
    period = periods(steps.model.outputs)
    C = derivatives(outputs, gaps, period[:, None])
    y = contradicting(steps.model.outputs, y, outputs[:, 0])
    live.innovation[:] = shortest(y - outputs[:, 0], period)
    live.S[:] = np.where(np.isnan(y), np.nan, ((C @ P) * C).sum(axis=1) + live.noise)
    shift = np.zeros(d)
    for i in np.flatnonzero(~np.isnan(y)):
        K = live.corrected * (P @ C[i]) / (C[i] @ P @ C[i] + live.noise[i])
        shift += K * (live.innovation[i] - C[i] @ shift)
        J = unit - np.outer(K, C[i])
        P = J @ P @ J.T + live.noise[i] * np.outer(K, K)
    z = z + shift
    live.x[:], live.p[live.moving], live.P[:] = z[:n], z[n:], 0.5 * (P + P.T)
