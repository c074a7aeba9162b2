"""A solver that tells where its time goes: in compiled rollouts, or around them."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np

from benchmarks.runner import timed
from obs_ros import Estimate, Model, Record
from obs_ros.core.deadline import Deadline
from obs_ros.core.rng import random_generator
from obs_ros.core.typing import Array, IntArray
from obs_ros.horizon.settings import EstimationSettings
from obs_ros.horizon.solver import Solver
from obs_ros.integration.backends import Kernels
from obs_ros.integration.filter_pass import FilterPass
from obs_ros.integration.grid import Grid
from obs_ros.integration.path import LANES

Result = TypeVar('Result')


class Meter:
    """Kernels that count their calls, process time (s) and candidate-steps."""

    def __init__(self, kernels: Kernels) -> None:
        self.kernels = kernels
        self.name = kernels.name
        self.model = kernels.model
        self.compile_time = kernels.compile_time
        self.calls, self.steps, self.seconds = 0, 0, 0.0

    def squares(self, grid: Grid, prefixes: IntArray, x0: Array, p: Array) -> Array:
        """See `Kernels.squares`."""
        nodes = int(prefixes[-1])
        return self._met(grid, nodes, x0, lambda: self.kernels.squares(grid, prefixes, x0, p))

    def grams(self, grid: Grid, nodes: int, x0: Array, p: Array, width: int) -> Array:
        """See `Kernels.grams`."""
        return self._met(grid, nodes, x0, lambda: self.kernels.grams(grid, nodes, x0, p, width))

    def trajectories(self, grid: Grid, x0: Array, p: Array) -> tuple[Array, Array]:
        """See `Kernels.trajectories`."""
        return self._met(grid, grid.t.size, x0, lambda: self.kernels.trajectories(grid, x0, p))

    def paths(self, grid: Grid, x0: Array, p: Array) -> tuple[Array, Array, Array]:
        """See `Kernels.paths`."""
        return self._met(grid, grid.t.size, x0, lambda: self.kernels.paths(grid, x0, p))

    def filter(
        self, grid: Grid, x0: Array, p: Array, walks: Array, noise: Array,
        P0: Array | None = None, moving: IntArray | None = None,
    ) -> FilterPass:  # fmt: skip
        """See `Kernels.filter`; a pass counts as one chunk of candidates."""
        chunk = np.empty((x0.size, LANES))
        return self._met(
            grid, grid.t.size, chunk,
            lambda: self.kernels.filter(grid, x0, p, walks, noise, P0, moving),
        )  # fmt: skip

    def _met(self, grid: Grid, nodes: int, x0: Array, call: Callable[[], Result]) -> Result:
        begin = time.process_time()
        result = call()
        self.seconds += time.process_time() - begin
        self.calls += 1
        self.steps += int(grid.steps[: nodes - 1].sum()) * x0.shape[1]
        return result


class MeteredSolver(Solver):
    """A solver on kernels that count."""

    @property
    def kernels(self) -> Kernels:
        meter = Meter(super().kernels)
        object.__setattr__(self, 'meter', meter)
        return meter


@dataclass(frozen=True)
class Spent:
    """One solve: process time (s), of it in kernels, calls of them, candidate-steps, outcome."""

    seconds: float
    kernel_seconds: float
    calls: int
    steps: int
    estimate: Estimate

    @property
    def rest(self) -> float:
        """Share of the time outside the kernels."""
        return 1.0 - self.kernel_seconds / self.seconds


def spent(model: Model, record: Record, seed: int, **settings: Any) -> Spent:
    """Solve a window cold, to the end; the solver's settings as of `solve_window`."""
    solver = MeteredSolver.of(model, EstimationSettings(**settings))
    estimate, seconds = timed(lambda: solver.solve(record, random_generator(seed, 0), Deadline()))
    meter: Meter = object.__getattribute__(solver, 'meter')
    return Spent(seconds, meter.seconds, meter.calls, meter.steps, estimate)
