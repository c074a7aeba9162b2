"""The reference: scipy's implicit integrators, and least squares over them from the truth."""

from collections.abc import Callable

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import least_squares

from obs_ros import Model, Record
from obs_ros.core.typing import Array

RTOL = 1e-8
SHARE = 1e-10  # of the box: absolute tolerance of a state, relative to its width
STEP = 1e-6  # of the box: forward differences, a hundred times what RTOL leaves
FAR = 1e6  # deviations: stands for the residual of a candidate that the integrator gives up


def outputs(
    model: Model, t: Array, u: Array, x0: Array, p: Array, *, method: str = 'LSODA',
    rtol: float = RTOL,
) -> Array:  # fmt: skip
    """Return outputs (K, r) at t (K,) under held inputs u (K, m), by an integrator of scipy.

    It begins anew wherever an input leaps. NaN from where it gives up.
    """
    found = states(model, t, u, x0, p, method=method, rtol=rtol)
    rows = zip(t, found, u, strict=True)
    with np.errstate(all='ignore'):
        return np.array([model.output(s, tuple(x), tuple(v), tuple(p)) for s, x, v in rows])


def states(
    model: Model, t: Array, u: Array, x0: Array, p: Array, *, method: str = 'LSODA',
    rtol: float = RTOL,
) -> Array:  # fmt: skip
    """Return states (K, n) at t (K,), as `outputs` has them."""
    width = np.array([variable.upper - variable.lower for variable in model.states])
    leaps = 1 + np.flatnonzero((u[1:] != u[:-1]).any(axis=1)) if u.shape[1] else np.empty(0, int)
    x = np.full((t.size, len(x0)), np.nan)
    x[0], values, begin = x0, tuple(map(float, p)), 0
    for end in [*leaps[leaps < t.size - 1], t.size - 1]:
        inputs = tuple(map(float, u[begin]))

        def rates(s: float, now: Array, inputs: tuple[float, ...] = inputs) -> Array:
            return np.array(model.dynamics(s, tuple(now.tolist()), inputs, values))

        with np.errstate(all='ignore'):
            found = solve_ivp(
                rates, (t[begin], t[end]), x[begin], method, t[begin + 1 : end + 1], rtol=rtol,
                atol=SHARE * width * min(1.0, rtol / RTOL),
            )  # fmt: skip
        if not found.success:
            break
        x[begin + 1 : end + 1] = found.y.T
        begin = int(end)
    return x


class Reference:
    """Squares of a record in the noise's variance, over scipy's integrator.

    Points z (d,) lie in the unit box of states and parameters, on the parameters' scales.
    """

    def __init__(self, model: Model, record: Record, noise: Array) -> None:
        self.model = model
        self.record = record
        self.noise = noise
        self._log = np.array([v.scale == 'log' for v in model.variables])
        ends = np.array([(v.lower, v.upper) for v in model.variables]).T
        self._low, self._high = np.where(self._log, np.log(np.where(self._log, ends, 1.0)), ends)

    def point(self, values: Array) -> Array:
        """Return the point (d,) of initial states and parameters (d,) in their units."""
        scaled = np.where(self._log, np.log(np.where(self._log, values, 1.0)), values)
        return np.asarray((scaled - self._low) / (self._high - self._low))

    def values(self, z: Array) -> Array:
        """Return initial states and parameters (d,) in their units."""
        scaled = self._low + z * (self._high - self._low)
        return np.where(self._log, np.exp(np.where(self._log, scaled, 0.0)), scaled)

    def residuals(self, z: Array) -> Array:
        """Return the residuals (N,) of a point in deviations of the noise."""
        values, n = self.values(z), len(self.model.states)
        y = outputs(self.model, self.record.t, self.record.u, values[:n], values[n:])
        residuals = ((y - self.record.y) / self.noise).ravel()
        return np.clip(np.where(np.isnan(residuals), FAR, residuals), -FAR, FAR)

    def squares(self, values: Array) -> float:
        """Return the squares of initial states and parameters (d,) in their units."""
        return float(np.sum(self.residuals(self.point(values)) ** 2))

    def optimum(self, truth: Array) -> float:
        """Return the least squares that are met from the truth (d,)."""
        z = np.clip(self.point(truth), 0.0, 1.0)
        found = least_squares(
            self.residuals, z, forward(self.residuals), bounds=(0.0, 1.0), x_scale='jac',
            ftol=1e-6, xtol=1e-8, gtol=1e-8, max_nfev=30,
        )  # fmt: skip
        return 2.0 * float(found.cost)


def forward(function: Callable[[Array], Array]) -> Callable[[Array], Array]:
    """Return the derivatives of a function of points by differences that stay in the unit box."""

    def jacobian(z: Array) -> Array:
        base = function(z)
        columns = []
        for i in range(z.size):
            step = -STEP if z[i] > 0.5 else STEP
            moved = z.copy()
            moved[i] += step
            columns.append((function(moved) - base) / step)
        return np.array(columns).T

    return jacobian
