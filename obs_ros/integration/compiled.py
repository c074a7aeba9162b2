"""Rollouts compiled by Numba: one generated module per model, its kernels in the cache folder."""

from collections.abc import Callable
from types import ModuleType

import numba
import numpy as np

from obs_ros.core.model import Model
from obs_ros.core.typing import AnyArray, Array, IntArray
from obs_ros.integration import compiled_own_steps as own
from obs_ros.integration.delayed_outputs import Delayed
from obs_ros.integration.filter_pass import FilterPass, sizes
from obs_ros.integration.filter_step import LiveFilter
from obs_ros.integration.grid import Grid
from obs_ros.integration.kernel_modules import load_filter, load_module
from obs_ros.integration.path import LANES, Path, Stretch, always, lanes
from obs_ros.integration.rosenbrock_source import takes_own_steps

CompileError = numba.core.errors.NumbaError


class CompiledKernels:
    """Rolls candidates out at the speed of vectorised C; see `Kernels` for the methods."""

    name = 'numba'
    compile_time = 0.0

    def __init__(self, model: Model) -> None:
        self.model = model
        self.module = load_module(model)
        self.own_steps = takes_own_steps(model)
        self._filters: dict[int, ModuleType] = {}  # by number of states and moving parameters
        self._sizes = sizes(model)

    def squares(self, grid: Grid, prefixes: IntArray, x0: Array, p: Array) -> Array:
        """See `Kernels.squares`."""
        if self.own_steps and grid.is_free:
            return own.squares(self.module, self.model, grid, prefixes, x0, p)
        x, q, count = *padded(x0, p), x0.shape[1]
        out = np.empty((prefixes.size, len(self.model.outputs), x.shape[1]))
        if grid.injection is None:
            self.module.squares(*axis(grid), *measurements(grid), prefixes, count, x, q, out)
        else:
            self.module.squares_injected(*corrections(grid), prefixes, count, x, q, out)
        return out[:, :, :count]

    def grams(self, grid: Grid, nodes: int, x0: Array, p: Array, width: int) -> Array:
        """See `Kernels.grams`."""
        if self.own_steps and grid.is_free:
            return own.grams(self.module, self.model, grid, nodes, x0, p, width)
        x, q = padded(x0, p)
        out = np.empty((x0.shape[1] // width, width, width))
        if grid.injection is None:
            self.module.grams(*axis(grid), *measurements(grid), nodes, x, q, out)
        else:
            self.module.grams_injected(*corrections(grid), nodes, x, q, out)
        return out

    def trajectories(self, grid: Grid, x0: Array, p: Array, width: int = 1) -> tuple[Array, Array]:
        """See `Kernels.trajectories`."""
        if grid.injection is not None:
            states, _, outputs = self.paths(grid, x0, p)
            return states, outputs
        return self.scheduled(grid, x0, p[None], *always(grid.t.size), width)

    def scheduled(
        self, grid: Grid, x0: Array, p: Array, along: IntArray, there: IntArray, width: int = 1
    ) -> tuple[Array, Array]:
        """See `Kernels.scheduled`."""
        if self.own_steps and grid.is_free:
            order = along, there, width
            return own.scheduled(self.module, self.model, grid, x0, p, *order)[:2]
        count = x0.shape[1]
        x, q = filled(x0), filled(p)
        states = np.empty((grid.t.size, *x.shape))
        outputs = np.empty((grid.t.size, len(self.model.outputs), x.shape[1]))
        self.module.trajectories(*axis(grid), count, x, q, along, there, states, outputs)
        return states[..., :count], outputs[..., :count]

    def counts(self, grid: Grid, x0: Array, p: Array) -> IntArray:
        """See `Kernels.counts`."""
        if self.own_steps and grid.is_free:
            order = *always(grid.t.size), 1
            return own.scheduled(self.module, self.model, grid, x0, p[None], *order)[2]
        return np.repeat(grid.steps[:, None], x0.shape[1], axis=1)

    def restarted(self, grid: Grid, states: Array, p: Array) -> Array:
        """See `Kernels.restarted`."""
        x, q, count = filled(states), filled(p), states.shape[2]
        ends = np.empty((grid.t.size - 1, *x.shape[1:]))
        self.module.restarted(*axis(grid), count, x, q, ends)
        return ends[..., :count]

    def one_step(
        self, grid: Grid, states: tuple[Array, Array], moved: Array, sets: Array, along: IntArray,
        there: IntArray,
    ) -> tuple[Array, Array]:  # fmt: skip
        """See `Kernels.one_step`."""
        n, r = len(moved), len(self.model.outputs)
        m, own = n + sets.shape[2] - 1, LANES - 1
        lane = np.arange(-(-m // own) * LANES)
        lane = lane % LANES + lane // LANES * own  # one more than the number of what is moved
        lane[::LANES] = 0
        lane = np.where((lane > n) & (lane <= m), lane - n, 0)
        transition, sensitivity = np.empty((grid.t.size - 1, n, m)), np.empty((grid.t.size, r, m))
        self.module.one_step(
            *axis(grid), grid.y, grid.period, along, there, *map(np.ascontiguousarray, states),
            moved, np.ascontiguousarray(sets[:, :, lane]), transition, sensitivity,
        )  # fmt: skip
        return transition, sensitivity

    def paths(self, grid: Grid, x0: Array, p: Array) -> tuple[Array, Array, Array]:
        """See `Kernels.paths`."""
        injection, count = grid.injection, x0.shape[1]
        parameters = np.repeat(p[None], grid.t.size, axis=0)
        if injection is None:
            states, outputs = self.trajectories(grid, x0, p)
            return states, parameters, outputs
        x, q = padded(x0, p)
        states = np.empty((grid.t.size, *x.shape))
        moved = np.empty((grid.t.size, injection.moving.size, x.shape[1]))
        outputs = np.empty((grid.t.size, len(self.model.outputs), x.shape[1]))
        self.module.trajectories_injected(
            *corrections(grid), x0.shape[1], x, q, states, moved, outputs
        )
        parameters[:, injection.moving] = moved[..., :count]
        return states[..., :count], parameters, outputs[..., :count]

    def delayed(self, window: Delayed, x0: Array, p: Array) -> tuple[Array, Array]:
        """See `DelayedRollouts.delayed`."""
        count = x0.shape[1]
        every = x0, p, window.t, window.u, window.slope, window.offset
        x, q, t, u, slope, offset = (filled(each) for each in every)
        states = np.empty((window.at.size, *x.shape))
        outputs = np.zeros((window.slack.size, window.at.size, len(offset), x.shape[1]))
        self.module.delayed(
            window.start, t, window.steps, window.at, u, slope, window.along, window.there, offset,
            window.late, window.wanted, window.slack, x, q, states, outputs,
        )  # fmt: skip
        return states[..., :count], outputs[..., :count]

    def filter(
        self, grid: Grid, x0: Array, p: Array, walks: Array, noise: Array,
        P0: Array | None = None, moving: IntArray | None = None,
    ) -> FilterPass:  # fmt: skip
        """See `Kernels.filter`."""
        found = FilterPass.blank(grid, x0, p, walks, P0, moving)
        index = found.index
        if index.size not in self._filters:
            self._filters[index.size] = load_filter(self.model, index.size)
        self._filters[index.size].filter_pass(
            *axis(grid), grid.y, found.measured, grid.measured, grid.period,
            np.ascontiguousarray(x0), found.given, walks[index] ** 2, noise**2, found.prior,
            found.moving, *self._sizes[:, index], found.transition, found.sensitivity, found.gain,
            found.cross, found.S, found.innovations, found.means, found.covariances,
        )  # fmt: skip
        return found


class CompiledStepper:
    """Steps candidates on from output to output; see `Stepper` for the methods."""

    name = 'numba'
    compile_time = 0.0

    def __init__(self, model: Model) -> None:
        self.model = model
        self.module = load_module(model)
        self.measure = self.module.measure
        self._propagate = self.module.propagate
        self._steps: dict[int, Callable[..., None]] = {}  # of filters, by their number of variables

    def propagate(self, path: Path, x: Array, p: Array) -> None:
        """See `Stepper.propagate`."""
        self._propagate(path.t, path.dt, path.steps, path.u, path.slope, path.pieces, x, p)

    def filter(self, live: LiveFilter, path: Path, y: Array) -> None:
        """See `Stepper.filter`."""
        d = len(live.P)
        if d not in self._steps:
            self._steps[d] = load_filter(self.model, d).filter_step
        self._steps[d](
            path.t, path.dt, path.steps, path.u, path.slope, path.pieces, y, live.x, live.p, live.P,
            live.variances, live.noise, live.moving, live.corrected, *live.limits, live.innovation,
            live.S,
        )  # fmt: skip


class CompiledSeriesParallel:
    """Steps candidates on from measurement to measurement; see `SeriesParallel` for the methods."""

    name = 'numba'

    def __init__(self, model: Model, measured: IntArray) -> None:
        self.model = model
        self.measured = measured
        self._pursue = load_module(model).pursue

    def pursue(
        self, window: Stretch, lower: Array, upper: Array, x0: Array, p: Array
    ) -> tuple[Array, Array]:
        """See `SeriesParallel.pursue`."""
        squares, ends = np.empty(p.shape[1]), np.empty((x0.size, p.shape[1]))
        self._pursue(*window, self.measured, lower, upper, x0, p, squares, ends)
        return squares, ends


def axis(grid: Grid) -> tuple[AnyArray, ...]:
    """Return the arrays that say when, and with which inputs."""
    return grid.clock, grid.steps, grid.u, grid.slope


def measurements(grid: Grid) -> tuple[AnyArray, ...]:
    """Return the arrays that say what was measured."""
    return grid.y, grid.weight, grid.measured, grid.period


def corrections(grid: Grid) -> tuple[AnyArray, ...]:
    """Return the arrays that say when, what was measured, and what that corrects."""
    injection = grid.injection
    assert injection is not None
    return (
        *axis(grid), *measurements(grid), injection.gain, injection.cross, injection.moving
    )  # fmt: skip


def padded(x0: Array, p: Array) -> tuple[Array, Array]:
    """Repeat the last candidate until the lanes are full."""
    count = x0.shape[1]
    width = lanes(count)
    if count == width:
        return np.ascontiguousarray(x0), np.ascontiguousarray(p)
    full = np.empty((len(x0), width)), np.empty((len(p), width))
    for all_lanes, values in zip(full, (x0, p), strict=True):
        all_lanes[:, :count] = values
        all_lanes[:, count:] = values[:, -1:]
    return full


def filled(values: Array) -> Array:
    """Repeat the last candidate's values (..., B) until the lanes are full."""
    count = values.shape[-1]
    width = lanes(count)
    if count == width:
        return np.ascontiguousarray(values)
    full = np.empty((*values.shape[:-1], width))
    full[..., :count] = values
    full[..., count:] = values[..., -1:]
    return full
