"""An independent judge of the search: scipy's least squares from many starts, truth included."""

from collections.abc import Mapping, Sequence

import numpy as np
from scipy.optimize import least_squares
from scipy.stats import qmc

from obs_ros import Model, Record
from obs_ros.core.typing import Array
from obs_ros.integration.backends import kernels_for
from obs_ros.integration.grid import Grid

HALF_STEP = 1e-6  # of central differences, in the unit box
TOLERANCE = 1e-9  # relative; 0.41 sigma^2 are 2e-4 of the squares of 1000 samples
MAX_EVALUATIONS = 300


class Judge:
    """Sum of squared residuals of one record, all outputs weighted equally, in their units.

    Shares with the library only the integration; derivatives, steps, bounds and starts are its own
    or scipy's. Points z (d,) lie in the unit box of the estimated names, in their order; the values
    of all others are given.
    """

    def __init__(
        self, model: Model, record: Record, estimated: Sequence[str], given: Mapping[str, float]
    ) -> None:
        self.estimated = tuple(estimated)
        self.lower = np.array([model.variable(name).lower for name in estimated])
        self.width = np.array([model.variable(name).upper for name in estimated]) - self.lower
        self._order = [variable.name for variable in model.variables]
        self._given = dict(given)
        self._states = len(model.states)
        self._kernels = kernels_for(model)
        self._grid = Grid.of(model, record, np.ones(len(model.outputs)))

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
        d = z.size
        ends = self._residuals(np.vstack([z + HALF_STEP * np.eye(d), z - HALF_STEP * np.eye(d)]))
        return (ends[:, :d] - ends[:, d:]) / (2.0 * HALF_STEP)

    def optimum(self, truth: Mapping[str, float], starts: int, seed: int) -> float:
        """Return the smallest sum of squares found from the truth and `starts` other points."""
        d = len(self.estimated)
        spread = qmc.LatinHypercube(d, rng=np.random.default_rng(seed)).random(starts)
        return min(self._polished(z) for z in [self.point(truth), *spread])

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
        values = np.array(
            [
                columns[name] if name in columns else np.full(len(z), self._given[name])
                for name in self._order
            ]
        )
        x0, p = values[: self._states], values[self._states :]
        _, outputs = self._kernels.trajectories(self._grid, x0, p)
        measured = self._grid.weight > 0.0
        return np.asarray((outputs - self._grid.y[:, :, None])[measured])
