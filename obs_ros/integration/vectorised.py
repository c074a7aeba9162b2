"""Rollouts on NumPy: the same results as the compiled ones, one array entry per candidate."""

from functools import partial
from typing import Any

import numpy as np

from obs_ros.core.model import Model
from obs_ros.core.periods import shortest
from obs_ros.core.typing import Array, IntArray
from obs_ros.integration.delayed_outputs import Delayed, Tracks, outputs_at
from obs_ros.integration.filter_pass import FilterPass, run
from obs_ros.integration.grid import Grid, Injection
from obs_ros.integration.own_steps import followed, leaders
from obs_ros.integration.rosenbrock_source import takes_own_steps
from obs_ros.integration.steps import STEPS


class NumpyKernels:
    """Rolls candidates out without a compiler; an order of magnitude or two slower."""

    name = 'numpy'
    compile_time = 0.0

    def __init__(self, model: Model) -> None:
        self.model = model
        self.step = STEPS[model.method]
        self.own_steps = takes_own_steps(model)

    def squares(self, grid: Grid, prefixes: IntArray, x0: Array, p: Array) -> Array:
        """See `Kernels.squares`."""
        total = np.zeros((prefixes.size, len(self.model.outputs), x0.shape[1]))
        block = np.searchsorted(prefixes, np.arange(prefixes[-1]), side='right')
        for k, _, _, y in self._nodes(grid, int(prefixes[-1]), x0, p):
            if grid.measured[k]:
                for i, yi in enumerate(shown(grid, k, y)):
                    error = shortest(np.asarray(yi - grid.y[k, i]), grid.period[i])
                    total[block[k], i] += (grid.weight[k, i] * error) ** 2
        return total

    def grams(self, grid: Grid, nodes: int, x0: Array, p: Array, width: int) -> Array:
        """See `Kernels.grams`."""
        starts = x0.shape[1] // width
        total = np.zeros((starts, width, width))
        for k, _, _, y in self._nodes(grid, nodes, x0, p, width):
            if grid.measured[k]:
                for i, yi in enumerate(shown(grid, k, y)):
                    lanes = grid.weight[k, i] * np.broadcast_to(yi, x0.shape[1:])
                    lanes = lanes.reshape(starts, width)
                    row = lanes - lanes[:, :1]
                    row[:, 0] = lanes[:, 0] - grid.weight[k, i] * grid.y[k, i]
                    row = shortest(row, grid.weight[k, i] * grid.period[i])
                    total += row[:, :, None] * row[:, None, :]
        return total

    def trajectories(self, grid: Grid, x0: Array, p: Array, width: int = 1) -> tuple[Array, Array]:
        """See `Kernels.trajectories`."""
        states, _, outputs = self._paths(grid, x0, p, width)
        return states, outputs

    def scheduled(
        self, grid: Grid, x0: Array, p: Array, along: IntArray, there: IntArray, width: int = 1
    ) -> tuple[Array, Array]:
        """See `Kernels.scheduled`."""
        sets, x, track = [tuple(each) for each in p], tuple(x0), None
        if self.own_steps and grid.is_free:
            lead = leaders(x0.shape[1], width)
            track = followed(self.model, grid, grid.t.size, x0, p, lead, along)[0]
        states = np.empty((grid.t.size, *x0.shape))
        outputs = np.empty((grid.t.size, len(self.model.outputs), x0.shape[1]))
        with np.errstate(all='ignore'):
            for k in range(grid.t.size):
                if track is not None:
                    x = tuple(track[k])
                elif k > 0:
                    x = self._advance(grid, k - 1, x, sets[along[k - 1]])
                states[k] = _stacked(x, x0)
                y = self.model.output(grid.clock[k], x, tuple(grid.u[k]), sets[there[k]])
                outputs[k] = _stacked(y, x0)
        return states, outputs

    def counts(self, grid: Grid, x0: Array, p: Array) -> IntArray:
        """See `Kernels.counts`."""
        if self.own_steps and grid.is_free:
            lead = leaders(x0.shape[1], 1)
            return followed(self.model, grid, grid.t.size, x0, p, lead)[1]
        return np.repeat(grid.steps[:, None], x0.shape[1], axis=1)

    def restarted(self, grid: Grid, states: Array, p: Array) -> Array:
        """See `Kernels.restarted`."""
        ends = np.empty((grid.t.size - 1, *states.shape[1:]))
        with np.errstate(all='ignore'):
            for k in range(grid.t.size - 1):
                ends[k] = _stacked(self._advance(grid, k, tuple(states[k]), tuple(p)), states[k])
        return ends

    def one_step(
        self, grid: Grid, states: tuple[Array, Array], moved: Array, sets: Array, along: IntArray,
        there: IntArray,
    ) -> tuple[Array, Array]:  # fmt: skip
        """See `Kernels.one_step`."""
        n, r = len(moved), len(self.model.outputs)
        m = n + sets.shape[2] - 1
        lanes = np.concatenate([np.repeat(sets[:, :, :1], n, axis=2), sets], axis=2)
        transition, sensitivity = np.empty((grid.t.size - 1, n, m)), np.empty((grid.t.size, r, m))
        with np.errstate(all='ignore'):
            for k, pair in enumerate(zip(*states, strict=True)):
                both = [np.repeat(state[:, None], 1 + m, axis=1) for state in pair]
                for around in both:
                    around[np.arange(n), np.arange(n)] += moved
                x = tuple(both[0])
                y = self.model.output(grid.clock[k], x, tuple(grid.u[k]), tuple(lanes[there[k]]))
                rows = _stacked(shown(grid, k, y), around)
                off = np.delete(rows, n, axis=1) - rows[:, n : n + 1]
                sensitivity[k] = shortest(off, grid.period[:, None])
                if k + 1 < grid.t.size:
                    x = tuple(both[1])
                    ends = _stacked(self._advance(grid, k, x, tuple(lanes[along[k]])), around)
                    transition[k] = np.delete(ends, n, axis=1) - ends[:, n : n + 1]
        return transition, sensitivity

    def paths(self, grid: Grid, x0: Array, p: Array) -> tuple[Array, Array, Array]:
        """See `Kernels.paths`."""
        return self._paths(grid, x0, p, 1)

    def _paths(self, grid: Grid, x0: Array, p: Array, width: int) -> tuple[Array, Array, Array]:
        states = np.empty((grid.t.size, *x0.shape))
        parameters = np.empty((grid.t.size, *p.shape))
        outputs = np.empty((grid.t.size, len(self.model.outputs), x0.shape[1]))
        for k, *found in self._nodes(grid, grid.t.size, x0, p, width):
            for all_nodes, values in zip((states, parameters, outputs), found, strict=True):
                for i, value in enumerate(values):
                    all_nodes[k, i] = value
        return states, parameters, outputs

    def filter(
        self, grid: Grid, x0: Array, p: Array, walks: Array, noise: Array,
        P0: Array | None = None, moving: IntArray | None = None,
    ) -> FilterPass:  # fmt: skip
        """See `Kernels.filter`."""
        found = FilterPass.blank(grid, x0, p, walks, P0, moving)
        with np.errstate(all='ignore'):
            run(found, self.model, grid, partial(self._advance, grid), x0, walks, noise)
        return found

    def delayed(self, window: Delayed, x0: Array, p: Array) -> tuple[Array, Array]:
        """See `DelayedRollouts.delayed`."""
        dynamics, sets = self.model.dynamics, [tuple(each) for each in p]
        t, x = window.clock, tuple(x0)
        states = np.empty((len(t), *x0.shape))
        begin, end = np.empty((2, len(t) - 1, *x0.shape))
        with np.errstate(all='ignore'):
            states[0] = x0
            for f in range(len(t) - 1):
                q, h = sets[window.along[f]], window.t[f + 1] - window.t[f]
                first, last = tuple(window.u[f]), tuple(window.u[f] + h * window.slope[f])
                begin[f] = _stacked(dynamics(t[f], x, first, q), x0)
                x = self._advance(window, f, x, q)
                states[f + 1] = _stacked(x, x0)
                end[f] = _stacked(dynamics(t[f + 1], x, last, q), x0)
            outputs = outputs_at(self.model, window, Tracks(states, begin, end), p)
        return states[window.at], outputs

    def _nodes(self, grid: Grid, nodes: int, x0: Array, p: Array, width: int = 1) -> Any:
        """Yield node, states, parameters and outputs; silent about candidates that diverge."""
        x, parameters, track = tuple(x0), tuple(p), None
        if self.own_steps and grid.is_free:
            lead = leaders(x0.shape[1], width)
            track = followed(self.model, grid, nodes, x0, p, lead)[0]
        with np.errstate(all='ignore'):
            for k in range(nodes):
                if track is not None:
                    x = tuple(track[k])
                elif k > 0:
                    x = self._advance(grid, k - 1, x, parameters)
                y = self.model.output(grid.clock[k], x, tuple(grid.u[k]), parameters)
                if grid.injection is not None and grid.measured[k]:
                    x, parameters, y = corrected(grid, grid.injection, k, x, parameters, y)
                yield k, x, parameters, y

    def _advance(self, grid: Grid | Delayed, k: int, x: Any, p: Any) -> Any:
        h = (grid.t[k + 1] - grid.t[k]) / grid.steps[k]
        for j in range(grid.steps[k]):
            s = j * h
            u0, u1, u2 = (
                tuple(grid.u[k] + after * grid.slope[k]) for after in (s, s + 0.5 * h, s + h)
            )
            x = self.step(self.model.dynamics, grid.clock[k] + s, h, x, u0, u1, u2, p)
        return x


def shown(grid: Grid, k: int, y: Any) -> Any:
    """Return outputs at node k as sensors show them where these are saturated."""
    return y if grid.ends is None else [shown_by(grid, k, i, yi) for i, yi in enumerate(y)]


def shown_by(grid: Grid, k: int, i: int, output: Any) -> Any:
    """Return output i at node k as its sensor shows it; see `Ends`."""
    ends = grid.ends
    return output if ends is None else np.clip(output, ends.low[k, i], ends.high[k, i])


def _stacked(entries: Any, like: Array) -> Array:
    """Return entries, each a number or one per candidate, as an array of that shape (n, B)."""
    return np.stack([np.broadcast_to(entry, like.shape[1:]) for entry in entries])


def corrected(grid: Grid, injection: Injection, k: int, x: Any, p: Any, y: Any) -> Any:
    """Return states, parameters and outputs after the updates at node k; see `Injection`."""
    x, p, y = list(x), list(p), list(y)
    errors: dict[int, Any] = {}
    for i in np.flatnonzero(grid.weight[k]).tolist():
        for j, error in errors.items():
            y[i] = y[i] + injection.cross[k, i, j] * error
        y[i] = shown_by(grid, k, i, y[i])
        errors[i] = grid.y[k, i] - y[i]
        if grid.period[i]:
            errors[i] = shortest(np.asarray(errors[i]), grid.period[i])
            y[i] = grid.y[k, i] - errors[i]
        for s in range(len(x)):
            x[s] = x[s] + injection.gain[k, i, s] * errors[i]
        for s in injection.moving:
            p[s] = p[s] + injection.gain[k, i, len(x) + s] * errors[i]
    return tuple(x), tuple(p), tuple(y)
