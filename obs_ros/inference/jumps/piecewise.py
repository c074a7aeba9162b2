"""Windows in which parameters jump at change points, and are constant between them.

The model of a window is

    x' = f(t, x, u, p(t)),    y = h(t, x, u, p(t)),    p(t) = p_0 + sum_k d_k 1(t >= t_k)

with x(0), p_0, the times t_k and the sizes d_k of the jumps unknown. Sizes are a priori normal with
the variance of a box, whatever the value before; times lie anywhere in the window.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from obs_ros.core.typing import Array, BoolArray, IntArray
from obs_ros.inference.jumps.layout import Layout
from obs_ros.inference.jumps.linearisation import Linearisation, differences
from obs_ros.inference.jumps.settings import JUMP_SETTINGS, JumpSettings
from obs_ros.inference.objective import Objective
from obs_ros.inference.prior import Prior
from obs_ros.integration.backends import Kernels
from obs_ros.integration.grid import Grid


@dataclass(frozen=True, eq=False)
class PiecewiseProblem:
    """Least squares of one window in which the parameters of `events` jump, see `Layout`.

    The squares of points (B, D) are those of the residuals, of the prior of z, and of the prior of
    each jump's size.
    """

    objective: Objective
    prior: Prior
    events: tuple[tuple[int, ...], ...] = ()
    settings: JumpSettings = JUMP_SETTINGS

    @cached_property
    def layout(self) -> Layout:
        """Layout of the points."""
        return Layout(self.objective.dimension, self.events)

    @cached_property
    def _measured(self) -> tuple[BoolArray, Array, Array]:
        """Mask (K, r) of measured values, their weights (M, 1) and scaled values (M,)."""
        grid = self.objective.grid
        mask = np.asarray(grid.weight > 0.0)
        weight = grid.weight[mask]
        return mask, weight[:, None], weight * grid.y[mask]

    @cached_property
    def _last(self) -> int:
        """The last node at which any output was measured."""
        return int(np.flatnonzero(self.objective.grid.measured)[-1])

    @cached_property
    def _t(self) -> Array:
        """Nodes (K,) in s from the start: seconds since 1970 would round small steps away."""
        return np.asarray(self.objective.grid.t - self.objective.grid.t[0])

    @property
    def limits(self) -> Array:
        """Least and largest values (2, D)."""
        z = self.objective.limits
        if not self.events:
            return z
        columns = [z]
        for event in self.events:
            columns += [np.array([[0.0], [1.0]]), z[:, list(event)]]
        return np.hstack(columns)

    @property
    def nodes(self) -> int:
        """Number of nodes of the window, K."""
        return self.objective.nodes

    def costs(self, z: Array) -> Array:
        """Return the cost (B,) of every point (B, D): squares of residuals and priors."""
        costs = []
        with np.errstate(all='ignore'):  # the model may diverge
            for point in z:
                r = self.rows(point[None])[:, 0] - self._measured[2]
                off = point - self.mean(point)
                costs.append(r @ r + off @ self.precision(point) @ off)
        return np.array(costs)

    def count(self, nodes: int) -> int:
        """See `Objective.count`."""
        return self.objective.count(nodes)

    def floor(self, nodes: int) -> float:
        """See `Objective.floor`."""
        return self.objective.floor(nodes)

    def linearise(self, z: Array, h: Array, nodes: int) -> tuple[Array, Array, Array]:
        """Return squares (P,), half gradients (P, D) and Gauss-Newton Hessians (P, D, D)."""
        assert nodes == self.objective.nodes, 'a jump is sought in whole windows'
        parts = []
        with np.errstate(all='ignore'):  # the model may diverge
            for point, steps in zip(z, h, strict=True):
                linearisation = self.linearisation(point, steps)
                precision = self.precision(point)
                off = point - self.mean(point)
                r, jacobian = linearisation.residual, linearisation.jacobian
                parts.append((
                    r @ r + off @ precision @ off,
                    jacobian.T @ r + precision @ off,
                    jacobian.T @ jacobian + precision,
                ))  # fmt: skip
        squares, gradients, hessians = zip(*parts, strict=True)
        return np.array(squares), np.array(gradients), np.array(hessians)

    def mean(self, point: Array) -> Array:
        """Return the prior's mean (D,): that of a value after a jump is the one before."""
        if not self.events:
            return self.prior.mean
        mean = np.zeros(self.layout.size)
        mean[: self.layout.dimension] = self.prior.mean
        mean[self.layout.times] = point[self.layout.times]
        for jump in self.layout.jumped(point):
            mean[jump.after] = mean[jump.before]
        return mean

    def precision(self, point: Array) -> Array:
        """Return the prior's precision (D, D)."""
        if not self.events:
            return self.prior.precision.copy()
        d = self.layout.dimension
        precision = np.zeros((self.layout.size, self.layout.size))
        precision[:d, :d] = self.prior.precision
        weight = 1.0 / self.objective.unknowns.box_variances
        for jump in self.layout.jumped(point):
            before, after = jump.before, jump.after
            size = weight[jump.parameter - self.objective.unknowns.n_states]
            precision[before, before] += size
            precision[after, after] += size
            precision[before, after] -= size
            precision[after, before] -= size
        return precision

    def linearisation(self, point: Array, steps: Array) -> Linearisation:
        """Return residual and Jacobian at a point (D,), by forward differences of `steps` (D,)."""
        points = np.repeat(point[None], point.size + 1, axis=0)
        steps = self._inward(point, steps)
        columns = np.arange(point.size)
        points[1 + columns, columns] += steps
        taken = points[1 + columns, columns] - point
        states, outputs = self.roll(points)
        grid = self.objective.grid
        shown = np.ascontiguousarray(grid.shown(outputs))
        residual, jacobian = differences(shown, grid.y, grid.weight, grid.period, taken)
        end = states[self._last]
        return Linearisation(
            residual=residual,
            jacobian=jacobian,
            state=end[:, 0],
            state_jacobian=(end[:, 1:] - end[:, :1]) / taken,
            path=(states[:, :, 0].copy(), outputs[:, :, 0].copy()),  # not all lanes with it
        )

    def trajectory(self, point: Array) -> tuple[Array, Array]:
        """Return states (K, n) and scaled residuals (K, r) of one point; NaN = not measured."""
        states, outputs = self.roll(point[None])
        return states[:, :, 0], self.objective.grid.residuals(outputs[:, :, 0])

    def at_nodes(self, rows: Array) -> Array:
        """Return rows (M, D) of measured values at their nodes (K, r, D), 0 where none was."""
        mask = self._measured[0]
        found = np.zeros((*mask.shape, rows.shape[1]))
        found[mask] = rows
        return found

    def rows(self, points: Array) -> Array:
        """Return the scaled outputs (M, B) of points (B, D) wherever one was measured."""
        return self._rows(self.roll(points)[1])

    def roll(self, points: Array) -> tuple[Array, Array]:
        """Return states (K, n, B) and outputs (K, r, B) of points (B, D).

        All points must jump in the intervals of the first, and are integrated in its steps. In the
        interval of its jump a parameter has its mean over that interval, so that outputs depend
        smoothly on the time.
        """
        objective, layout = self.objective, self.layout
        grid, kernels, unknowns = objective.grid, objective.kernels, objective.unknowns
        objective.counter.candidates += len(points)
        x, p = unknowns.values(points[:, : layout.dimension])
        if not layout.events:
            states, outputs = kernels.trajectories(grid, x, p, len(points))
            return states, grid.nearest(outputs)
        first, times, intervals = 0, *self._times(points)
        if grid.injection is None:
            schedule = self._sets(points, times, intervals, p)
            states, outputs = kernels.scheduled(grid, x, *schedule)
            return states, grid.nearest(outputs)
        states = np.empty((grid.t.size, *x.shape))
        outputs = np.empty((grid.t.size, grid.y.shape[1], x.shape[1]))
        for k in sorted(set(intervals.tolist())):
            mixed, after = self._jumped(points, times, intervals, k, p)
            part = slice(first, k + 1)
            states[part], outputs[part], moved = _run(kernels, grid.stretch(first, k), x, p)
            for row, value in moved:
                mixed[row], after[row] = value, value
            # Measurements at the interval's end correct what comes after it.
            interval, x = grid.uncorrected.stretch(k, k + 1), np.ascontiguousarray(states[k])
            x = kernels.trajectories(interval, x, mixed, len(points))[0][1]
            first, p = k + 1, after
        rest = grid.stretch(first, grid.t.size - 1)
        states[first:], outputs[first:] = kernels.trajectories(rest, x, p, len(points))
        return states, grid.nearest(outputs)

    def _jumped(
        self, points: Array, times: Array, intervals: IntArray, k: int, p: Array
    ) -> tuple[Array, Array]:
        """Return the parameters (q, B) in the interval k, in which some jump, and after it."""
        layout, unknowns = self.layout, self.objective.unknowns
        rows = unknowns.index - len(unknowns.model.states)
        order = np.argsort(times[:, 0], kind='stable')
        mixed, after = p.copy(), p.copy()
        for event in order[intervals[order] == k]:
            share = (self._t[k + 1] - times[event]) / (self._t[k + 1] - self._t[k])
            for i, parameter in enumerate(layout.events[event]):
                place, row = layout.times[event] + 1 + i, rows[parameter]
                value = unknowns.scale.values(points[:, place], parameter)
                mixed[row] += share * (value - after[row])
                after[row] = value
        return mixed, after

    def schedule(self, point: Array) -> tuple[Array, IntArray, IntArray]:
        """Return the sets of parameters (S, q) of one point, and which hold where.

        Those are the places of sets between nodes and at nodes (K,).
        """
        p = self.objective.unknowns.values(point[None, : self.layout.dimension])[1]
        if not self.events:
            always = np.zeros(self.nodes, dtype=np.int64)
            return p.T, always, always
        sets, along, there = self._sets(point[None], *self._times(point[None]), p)
        return sets[:, :, 0], along, there

    def _sets(
        self, points: Array, times: Array, intervals: IntArray, p: Array
    ) -> tuple[Array, IntArray, IntArray]:
        """Return all sets of parameters (S, q, B), and those between nodes and at nodes."""
        sets, nodes = [p], self.objective.nodes
        along, there = np.zeros((2, nodes), dtype=np.int64)
        for k in sorted(set(intervals.tolist())):
            mixed, p = self._jumped(points, times, intervals, k, p)
            sets += [mixed, p]
            along[k], along[k + 1 :], there[k + 1 :] = len(sets) - 2, len(sets) - 1, len(sets) - 1
        return np.array(sets), along, there

    def _rows(self, outputs: Array) -> Array:
        mask, weight, _ = self._measured
        return np.asarray(weight * self.objective.grid.shown(outputs)[mask])

    def _times(self, points: Array) -> tuple[Array, IntArray]:
        """Return the events' times (E, B), in s from the window's start, and their intervals (E,).

        Those are the intervals in which the first point's lie.
        """
        t = self._t
        times = points[:, self.layout.times].T * t[-1]
        # What rounding took off a node is given back.
        above = np.searchsorted(t, times)
        for node in (np.minimum(above, t.size - 1), np.maximum(above - 1, 0)):
            nearest = t[node]
            times = np.where(np.abs(times - nearest) <= 4.0 * np.spacing(t[-1]), nearest, times)
        return times, interval_of(t, times[:, 0])

    def _inward(self, point: Array, steps: Array) -> Array:
        """Return steps (D,) towards the middle of box and, for a time, of its interval."""
        if not self.events:
            return np.where(point > 0.5, -steps, steps)
        z, t = point.copy(), self._t
        times, intervals = self._times(point[None])
        # As if the interval were the box.
        z[self.layout.times] = (times[:, 0] - t[intervals]) / (t[intervals + 1] - t[intervals])
        return np.where(z > 0.5, -steps, steps)


def _run(
    kernels: Kernels, stretch: Grid, x: Array, p: Array
) -> tuple[Array, Array, list[tuple[int, Array]]]:
    """Return states, outputs, and the parameters that walk with their values (B,) at the end."""
    moving = () if stretch.injection is None else stretch.injection.moving
    if not len(moving):
        return *kernels.trajectories(stretch, x, p, x.shape[1]), []
    states, parameters, outputs = kernels.paths(stretch, x, p)
    return states, outputs, [(int(row), parameters[-1, row]) for row in moving]


def interval_of(t: Array, times: Array) -> IntArray:
    """Return for each time the interval k with t[k] < time <= t[k + 1]; the nearest if none."""
    return np.clip(np.searchsorted(t, times, side='left') - 1, 0, t.size - 2)
