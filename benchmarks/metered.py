"""A solver that tells where its time goes: in compiled rollouts, or around them."""

import contextlib
import functools
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from typing import Any, TypeVar
from unittest import mock

from benchmarks.runner import timed
from obs_ros import Estimate, Model, Record
from obs_ros.core.deadline import Deadline
from obs_ros.core.rng import random_generator
from obs_ros.core.typing import Array, IntArray
from obs_ros.horizon.settings import EstimationSettings
from obs_ros.horizon.solver import Solver
from obs_ros.horizon.stepping import Integration
from obs_ros.integration.backends import Kernels
from obs_ros.integration.filter_pass import FilterPass
from obs_ros.integration.grid import Grid
from obs_ros.integration.linear_path import LinearPath
from obs_ros.integration.window_steps import Methods

Result = TypeVar('Result')


@dataclass
class Count:
    """Calls of kernels, their process time (s) and candidate-steps."""

    calls: int = 0
    steps: int = 0
    seconds: float = 0.0


class Meter:
    """Kernels that count their calls, process time (s) and candidate-steps.

    A filter's pass counts as the lanes of its central differences, 1 + 2 d of d variables, and each
    set of noise along a linearised window (see `linear_paths`) as one candidate of a step per node.
    Kernels of several methods of integration may have one `count`.
    """

    def __init__(self, kernels: Kernels, count: Count | None = None) -> None:
        self.kernels = kernels
        self.name = kernels.name
        self.model = kernels.model
        self.compile_time = kernels.compile_time
        self.count = count or Count()

    def squares(self, grid: Grid, prefixes: IntArray, x0: Array, p: Array) -> Array:
        """See `Kernels.squares`."""
        found = self._timed(lambda: self.kernels.squares(grid, prefixes, x0, p))
        return self._counted(found, grid, x0.shape[1], int(prefixes[-1]))

    def grams(self, grid: Grid, nodes: int, x0: Array, p: Array, width: int) -> Array:
        """See `Kernels.grams`."""
        found = self._timed(lambda: self.kernels.grams(grid, nodes, x0, p, width))
        return self._counted(found, grid, x0.shape[1], nodes)

    def trajectories(self, grid: Grid, x0: Array, p: Array, width: int = 1) -> tuple[Array, Array]:
        """See `Kernels.trajectories`."""
        found = self._timed(lambda: self.kernels.trajectories(grid, x0, p, width))
        return self._counted(found, grid, x0.shape[1])

    def paths(self, grid: Grid, x0: Array, p: Array) -> tuple[Array, Array, Array]:
        """See `Kernels.paths`."""
        found = self._timed(lambda: self.kernels.paths(grid, x0, p))
        return self._counted(found, grid, x0.shape[1])

    def filter(
        self, grid: Grid, x0: Array, p: Array, walks: Array, noise: Array,
        P0: Array | None = None, moving: IntArray | None = None,
    ) -> FilterPass:  # fmt: skip
        """See `Kernels.filter`."""
        found = self._timed(lambda: self.kernels.filter(grid, x0, p, walks, noise, P0, moving))
        return self._counted(found, grid, 1 + 2 * found.index.size)

    def one_step(
        self, grid: Grid, states: tuple[Array, Array], moved: Array, sets: Array, along: IntArray,
        there: IntArray,
    ) -> tuple[Array, Array]:  # fmt: skip
        """See `Kernels.one_step`."""
        found = self._timed(lambda: self.kernels.one_step(grid, states, moved, sets, along, there))
        return self._counted(found, grid, 1 + found[0].shape[2])

    def scheduled(
        self, grid: Grid, x0: Array, p: Array, along: IntArray, there: IntArray, width: int = 1
    ) -> tuple[Array, Array]:
        """See `Kernels.scheduled`."""
        found = self._timed(lambda: self.kernels.scheduled(grid, x0, p, along, there, width))
        return self._counted(found, grid, x0.shape[1])

    def counts(self, grid: Grid, x0: Array, p: Array) -> IntArray:
        """See `Kernels.counts`."""
        found = self._timed(lambda: self.kernels.counts(grid, x0, p))
        return self._counted(found, grid, x0.shape[1])

    def restarted(self, grid: Grid, states: Array, p: Array) -> Array:
        """See `Kernels.restarted`."""
        found = self._timed(lambda: self.kernels.restarted(grid, states, p))
        return self._counted(found, grid, states.shape[2])

    @contextlib.contextmanager
    def linear_paths(self) -> Iterator[None]:
        """Count the likelihoods along linearised windows, whoever asks for them."""
        plain = LinearPath.neg2_log_likelihood

        def counting(path: LinearPath, walks: Array, noise: Array) -> Array:
            found = self._timed(lambda: plain(path, walks, noise))
            self.count.steps += len(path.residuals) * walks.shape[1]
            return found

        with mock.patch.object(LinearPath, 'neg2_log_likelihood', counting):
            yield

    def _timed(self, call: Callable[[], Result]) -> Result:
        result, seconds = timed(call)
        self.count.seconds += seconds
        self.count.calls += 1
        return result

    def _counted(self, result: Result, grid: Grid, lanes: int, nodes: int | None = None) -> Result:
        last = grid.t.size if nodes is None else nodes
        self.count.steps += int(grid.steps[: last - 1].sum()) * lanes
        return result


@dataclass(frozen=True, eq=False)
class MeteredMethods(Methods):
    """The kernels of a model by method, all of one count."""

    count: Count = field(default_factory=Count)

    def kernels(self, method: str) -> Any:
        """Return the kernels that integrate by a method and count."""
        return Meter(super().kernels(method), self.count)


class MeteredSolver(Solver):
    """A solver on kernels that count, those that check how exact its steps are as well."""

    @functools.cached_property
    def count(self) -> Count:
        """The count of all its kernels."""
        return Count()

    @functools.cached_property
    def kernels(self) -> Any:
        """The kernels that count, always the same."""
        return Meter(super().kernels, self.count)

    @functools.cached_property
    def integration(self) -> Integration:
        """See `Solver.integration`."""
        plain = super().integration
        methods = MeteredMethods(plain.methods.model, plain.methods.backend, count=self.count)
        return replace(plain, methods=methods)


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
    """Solve a window cold, to the end, compiled; the solver's settings as of `solve_window`."""
    chosen = EstimationSettings(**settings)
    Solver.of(model, chosen).prepare()
    solver = MeteredSolver.of(model, chosen)
    meter: Meter = solver.kernels
    with meter.linear_paths():
        estimate, seconds = timed(
            lambda: solver.solve(record, random_generator(seed, 0), Deadline())
        )
    count = solver.count
    return Spent(seconds, count.seconds, count.calls, count.steps, estimate)
