"""An independent judge of the search: scipy's least squares from many starts, truth included."""

from collections.abc import Callable, Mapping, Sequence

import numpy as np
from scipy.optimize import least_squares
from scipy.stats import qmc

from obs_ros import Estimate, Model, Record
from obs_ros.core.typing import Array
from obs_ros.integration.backends import kernels_for
from obs_ros.integration.grid import Grid

HALF_STEP = 1e-6  # of central differences, in the unit box
# A point is at the optimum where its squares are at most so far above the least ones, in the
# noise's variance and for each unknown.
SAME_OPTIMUM = 0.1025
FINER = 4  # steps of a judge in one of the model, where searches choose theirs
TOLERANCE = 1e-9  # relative; 4 SAME_OPTIMUM are 2e-4 of the squares of 1000 samples
MAX_EVALUATIONS = 300
NEAR = 0.02  # of the box: the spread of starts about the truth
FAR = 1e9  # stands for the residual of a candidate that diverged; scipy refuses infinities


class Judge:
    """Sum of squared residuals of one record, in the outputs' units, or in `noise` (r,).

    Shares with the library only the integration; derivatives, steps, bounds and starts are its own
    or scipy's. Points z (d,) lie in the unit box of the estimated names, in their order; the values
    of all others are given. It takes `finer` times the steps that the model asks for: where a
    search chooses its own, the optimum in coarse steps is none of the plant.
    """

    def __init__(
        self,
        model: Model,
        record: Record,
        estimated: Sequence[str],
        given: Mapping[str, float],
        noise: Array | float = 1.0,
        finer: int = 1,
    ) -> None:
        self.estimated = tuple(estimated)
        self.lower = np.array([model.variable(name).lower for name in estimated])
        self.width = np.array([model.variable(name).upper for name in estimated]) - self.lower
        self._order = [variable.name for variable in model.variables]
        self._given = dict(given)
        self._states = len(model.states)
        self._kernels = kernels_for(model)
        grid = Grid.of(model, record, np.ones(len(model.outputs)))
        self._grid = grid if model.period is not None else grid.stepped(finer * grid.steps)
        self._measured = self._grid.weight > 0.0
        self._noise = np.broadcast_to(noise, record.y.shape)[self._measured][:, None]

    def squares(self, values: Mapping[str, float]) -> float:
        """Return the sum of squared residuals at named values."""
        return float(np.sum(self.residuals(self.point(values)) ** 2))

    def point(self, values: Mapping[str, float]) -> Array:
        """Return the point (d,) of named values."""
        return (np.array([values[name] for name in self.estimated]) - self.lower) / self.width

    def residuals(self, z: Array) -> Array:
        """Return the residuals (N,) of one point (d,)."""
        return self._residuals(z[None])[:, 0]

    def jacobian(self, z: Array) -> Array:
        """Return the derivatives (N, d) of the residuals by central differences."""
        return differences(self._residuals, z, HALF_STEP)

    def optimum(
        self, truth: Mapping[str, float], far: int, seed: int | Sequence[int], near: int = 0
    ) -> float:
        """Return the least squares from the truth, `near` points about it and `far` anywhere."""
        rng = np.random.default_rng(seed)
        z = np.clip(self.point(truth), 0.0, 1.0)
        about = np.clip(z + NEAR * rng.standard_normal((near, z.size)), 0.0, 1.0)
        spread = qmc.LatinHypercube(z.size, rng=rng).random(far)
        return min(self._polished(start) for start in [z, *about, *spread])

    def bound(self, truth: Mapping[str, float], sigma: float) -> Array:
        """Return the Cramér-Rao bound (d, d) on the covariance, in the unknowns' units."""
        jacobian = self.jacobian(self.point(truth)) / self.width
        return sigma**2 * np.linalg.inv(jacobian.T @ jacobian)

    def _polished(self, z: Array) -> float:
        found = least_squares(
            self.residuals,
            z,
            self.jacobian,
            bounds=(0.0, 1.0),
            method='trf',
            x_scale='jac',
            ftol=TOLERANCE,
            xtol=TOLERANCE,
            gtol=TOLERANCE,
            max_nfev=MAX_EVALUATIONS,
        )
        return 2.0 * float(found.cost)

    def _residuals(self, z: Array) -> Array:
        """Return the residuals (N, B) of points (B, d)."""
        columns = dict(zip(self.estimated, (self.lower + z * self.width).T, strict=True))
        given = {name: np.full(len(z), value) for name, value in self._given.items()} | columns
        values = np.array([given[name] for name in self._order])
        x0, p = values[: self._states], values[self._states :]
        with np.errstate(all='ignore'):  # of a candidate that diverges
            _, outputs = self._kernels.trajectories(self._grid, x0, p)
            return finite((outputs - self._grid.y[:, :, None])[self._measured] / self._noise)


def values_of(estimate: Estimate) -> dict[str, float]:
    """Return the initial states and the parameters by name."""
    return {**estimate.initial_state, **estimate.parameters}


def finite(residuals: Array) -> Array:
    """Return residuals that are large where they were infinite or nothing."""
    return np.asarray(np.clip(np.where(np.isnan(residuals), FAR, residuals), -FAR, FAR))


def differences(function: Callable[[Array], Array], z: Array, half_step: float) -> Array:
    """Return the central differences (N, d) at z (d,) of a function of points (B, d) to (N, B)."""
    h = half_step * np.eye(z.size)
    ends = function(np.vstack([z + h, z - h]))
    return np.asarray((ends[:, : z.size] - ends[:, z.size :]) / (2.0 * half_step))
