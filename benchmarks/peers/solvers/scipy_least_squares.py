"""scipy's trust-region least squares on compiled residuals.

As it is, with its own differences and its own end; with its Jacobian in one of our rollouts; and so
again and again from other points, until the oracle stops it.
"""

from collections.abc import Callable

import numpy as np
from scipy.optimize import least_squares

from benchmarks.judge import HALF_STEP, differences
from benchmarks.peers.problem import Oracle, Problem
from benchmarks.peers.registry import Solve
from obs_ros.core.typing import Array

MAX_EVALUATIONS = 300
FAILED = 1e6


def once(problem: Problem) -> Solve:
    """Start at one random point, with scipy's forward differences."""
    return one_start(lambda window: '2-point')


def once_batched(problem: Problem) -> Solve:
    """Start at one random point, with central differences in one rollout."""
    return one_start(lambda window: window.jacobian)


def one_start(jacobian: Callable[['Window'], object]) -> Solve:
    """Search from one random point to scipy's own end."""

    def solve(oracle: Oracle, seed: int) -> None:
        window, z = Window(oracle), np.random.default_rng(seed).random(oracle.problem.d)
        oracle.note(descend(window.residuals, z, jacobian(window))[None])

    return solve


def restarts(problem: Problem) -> Solve:
    """Start again and again, asking the oracle at every new point."""

    def solve(oracle: Oracle, seed: int) -> None:
        window, rng = Window(oracle), np.random.default_rng(seed)

        def asking(z: Array) -> Array:
            r = window.residuals(z)
            cost = float(r @ r)
            if cost < oracle.least:
                oracle.best, oracle.least = z.copy(), cost
            oracle.check()
            return r

        while True:
            descend(asking, rng.random(oracle.problem.d), window.jacobian)

    return solve


def descend(residuals: Callable[[Array], Array], z: Array, jacobian: object) -> Array:
    """Return where scipy ends from z (d,), with the default tolerances."""
    return least_squares(
        residuals, z, jacobian, bounds=(0.0, 1.0), x_scale='jac', max_nfev=MAX_EVALUATIONS
    ).x


class Window:
    """Residuals of a window whose samples are all measured, in units of the noise, compiled."""

    def __init__(self, oracle: Oracle) -> None:
        self.problem = oracle.problem
        self.objective = oracle.problem.objective
        grid = self.objective.grid
        self.weight = grid.weight.reshape(-1, 1)
        self.measured = (grid.y * grid.weight).ravel()

    def residuals(self, z: Array) -> Array:
        """Return the residuals (N,) of one point (d,)."""
        r = self._outputs(z[None])[:, 0] - self.measured
        return r if np.isfinite(r).all() else np.full(r.size, FAILED)

    def jacobian(self, z: Array) -> Array:
        """Return their derivatives (N, d) by central differences, in one rollout."""
        return np.nan_to_num(differences(self._outputs, z, HALF_STEP))

    def _outputs(self, z: Array) -> Array:
        objective = self.objective
        _, y = objective.kernels.trajectories(objective.grid, *objective.unknowns.values(z))
        return y.reshape(-1, len(z)) * self.weight
