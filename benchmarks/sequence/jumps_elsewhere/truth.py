"""The true course of a run, by an integrator of eighth order: Dormand & Prince 1989."""

from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

from benchmarks.sequence.plants import Parameters
from obs_ros.core.typing import Array

TOLERANCE = 1e-9  # relative; absolute beside states of the size of one
TINY = 1e-10

Rates = Callable[[float, Array, Array, Array], Sequence[float]]  # at t, x (n,), u (m,), p (q,)


class Course(NamedTuple):
    """Parameters over time: they jump; one, at `place`, may be multiplied by `factor(t)`.

    `corners` are the times (s) at which `factor` is not smooth.
    """

    parameters: Parameters
    place: int = 0
    factor: Callable[[Array], Array] | None = None
    corners: tuple[float, ...] = ()

    def at(self, t: Array, since: Array | None = None) -> Array:
        """Return the values (K, q) at times t (K,), of the stretches that hold `since`."""
        values = self.parameters.before(t if since is None else since).copy()
        if self.factor is not None:
            values[:, self.place] *= self.factor(t)
        return values

    @property
    def breaks(self) -> Array:
        """The times (s) at which parameters jump or change their slope."""
        return np.union1d(self.parameters.since[1:], self.corners)


def trajectory(rates: Rates, t: Array, u: Array, x0: Array, course: Course) -> Array:
    """Return the states (K, n) at times t (K,); inputs u (K, m) hold from sample to sample."""
    moved = t[1:][np.any(np.diff(u, axis=0) != 0.0, axis=1)] if u.size else np.empty(0)
    inside = course.breaks[(course.breaks > t[0]) & (course.breaks < t[-1])]
    nodes = np.unique(np.concatenate([t[:1], moved, inside, t[-1:]]))
    x, states = np.asarray(x0, dtype=np.float64), np.empty((t.size, x0.size))
    states[0] = x
    for begin, end in pairwise(nodes):
        middle = np.array([0.5 * (begin + end)])
        held = u[np.searchsorted(t, middle[0]) - 1]
        slope = _slope(rates, course, held, middle)
        inner = np.flatnonzero((t > begin) & (t <= end))
        asked = np.union1d(t[inner], end)
        found = solve_ivp(slope, (begin, end), x, 'DOP853', asked, rtol=TOLERANCE, atol=TINY)
        if not found.success:
            raise ArithmeticError(f'no course from {begin:g} to {end:g} s: {found.message}')
        states[inner] = found.y.T[np.searchsorted(asked, t[inner])]
        x = found.y[:, -1]
    return states


def _slope(
    rates: Rates, course: Course, held: Array, since: Array
) -> Callable[[float, Array], Sequence[float]]:
    """Return the rates at t and x (n,) under the inputs `held`, in the stretch of `since`."""
    if course.factor is None:
        p = course.at(since)[0]
        return lambda now, x: rates(now, x, held, p)
    return lambda now, x: rates(now, x, held, course.at(np.array([now]), since)[0])
