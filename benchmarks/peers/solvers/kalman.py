"""Kalman filters of filterpy on states and parameters together, parameters standing still.

They go through the window once and know its end only. Our compiled rollout carries all their points
in one call. They start at the first measurement, elsewhere in the middle of the box, and are as
uncertain as the box; a value that leaves the box is put back to its edge.
"""

import numpy as np
from filterpy.kalman import ExtendedKalmanFilter, MerweScaledSigmaPoints, UnscentedKalmanFilter

from benchmarks.judge import differences
from benchmarks.peers.problem import Filtered, Oracle, Problem
from benchmarks.peers.registry import Solve
from obs_ros import Record
from obs_ros.core.typing import Array
from obs_ros.integration.grid import Grid

HALF_STEP = 1e-5  # of central differences, in the unit box
# Standard deviations of the process noise per sample, in the box: one choice for both
# cases, from a grid on other windows.
STATE_DRIFT, PARAMETER_DRIFT = 1e-5, 1e-4


def extended(problem: Problem) -> Solve:
    """Extended Kalman filter, Jacobians by central differences."""

    def solve(oracle: Oracle, seed: int) -> Filtered:
        plant = Plant(oracle.problem)
        ekf = Extended(plant.d, plant.r)
        ekf.plant = plant
        plant.start(ekf)
        for k, y in enumerate(plant.y):
            if k > 0:
                ekf.F = differences(lambda z: plant.advanced(z).T, ekf.x, HALF_STEP)
                ekf.predict()
            ekf.update(y, plant.output_jacobian, plant.output)
            ekf.x = np.clip(ekf.x, 0.0, 1.0)
        return plant.filtered(ekf.x)

    return solve


def unscented(problem: Problem) -> Solve:
    """Unscented Kalman filter with Merwe's points."""

    def solve(oracle: Oracle, seed: int) -> Filtered:
        plant = Plant(oracle.problem)
        points = MerweScaledSigmaPoints(plant.d, alpha=1e-1, beta=2.0, kappa=0.0)
        ukf = AllPoints(plant.d, plant.r, 1.0, plant.output, None, points)
        ukf.plant = plant
        plant.start(ukf)
        for k, y in enumerate(plant.y):
            if k > 0:
                ukf.predict()
            else:
                ukf.sigmas_f = points.sigma_points(ukf.x, ukf.P)
            ukf.update(y)
            ukf.x = np.clip(ukf.x, 0.0, 1.0)
            ukf.P = 0.5 * (ukf.P + ukf.P.T)
        return plant.filtered(ukf.x)

    return solve


class Extended(ExtendedKalmanFilter):
    """Follows the plant itself, not its linearisation."""

    plant: 'Plant'

    def predict_x(self, u: object = 0) -> None:
        self.x = self.plant.advanced(self.x[None])[0]


class AllPoints(UnscentedKalmanFilter):
    """Carries all sigma points at once."""

    plant: 'Plant'

    def compute_process_sigmas(self, dt: float, fx: object = None, **fx_args: object) -> None:
        points = self.points_fn.sigma_points(self.x, self.P)
        self.sigmas_f = self.plant.advanced(points)


class Plant:
    """The window's plant on points (B, d) of the unit box; outputs in units of their noise."""

    def __init__(self, problem: Problem) -> None:
        record, model = problem.record, problem.model
        self.problem = problem
        self.d, self.r, self.n = problem.d, len(model.outputs), len(model.states)
        self.y = record.y / problem.noise
        two = Record(record.t[:2], record.u[:2], record.y[:2])
        self.grid = Grid.of(model, two, np.ones(self.r))
        self.u = tuple(record.u[0])

    def advanced(self, z: Array) -> Array:
        """Return the points one sample later."""
        problem, n = self.problem, self.n
        x0, p = problem.objective.unknowns.values(z)
        states, _ = problem.objective.kernels.trajectories(self.grid, x0, p)
        after = z.copy()
        after[:, :n] = (states[1].T - problem.objective.unknowns.scale.lower[:n]) / problem.width[
            :n
        ]
        return after

    def outputs(self, z: Array) -> Array:
        """Return the outputs (B, r)."""
        x, p = self.problem.objective.unknowns.values(z)
        y = self.problem.model.output(0.0, tuple(x), self.u, tuple(p))
        return np.stack(y, axis=1) / self.problem.noise

    def output(self, z: Array) -> Array:
        """Return the outputs (r,) of one point (d,)."""
        return self.outputs(z[None])[0]

    def output_jacobian(self, z: Array) -> Array:
        """Return the derivatives (r, d) of the outputs."""
        return differences(lambda points: self.outputs(points).T, z, HALF_STEP)

    def start(self, kalman: ExtendedKalmanFilter | UnscentedKalmanFilter) -> None:
        """Set the filter's prior, before the first sample: a box's mean and variance."""
        drift = np.full(self.d, PARAMETER_DRIFT)
        drift[: self.n] = STATE_DRIFT
        kalman.x = np.full(self.d, 0.5)
        kalman.P = np.eye(self.d) / 12.0
        kalman.Q, kalman.R = np.diag(drift**2), np.eye(self.r)

    def filtered(self, z: Array) -> Filtered:
        """Return a point's states and parameters in their units."""
        state, parameters = np.split(self.problem.values(z), [self.n])
        return Filtered(state, parameters)
