"""Windows in which parameters jump at change points, and are constant between them.

The model of a window is

    x' = f(t, x, u, p(t)),    y = h(t, x, u, p(t)),    p(t) = p_0 + sum_k d_k 1(t >= t_k)

with x(0), p_0, the times t_k and the sizes d_k of the jumps unknown. Sizes are a priori normal with
the variance of a box, whatever the value before; times lie anywhere in the window.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from obs_ros.core.typing import Array, BoolArray, IntArray
from obs_ros.inference.jumps.layout import Layout
from obs_ros.inference.jumps.linearisation import Linearisation, differences
from obs_ros.inference.jumps.schedule import Placed, Schedule, moments, normal, scheduled
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
    def _placed(self) -> Placed:
        """The jumps of single parameters."""
        unknowns, jumps = self.objective.unknowns, []
        for event, (place, parameters) in enumerate(
            zip(self.layout.times.tolist(), self.events, strict=True)
        ):
            jumps += [(event, each, place + 1 + i) for i, each in enumerate(parameters)]
        event, parameter, after = np.array(jumps, dtype=np.int64).T.copy()
        row = unknowns.index[parameter] - len(unknowns.model.states)
        weight = 1.0 / unknowns.box_variances[parameter - unknowns.n_states]
        return Placed(event, parameter, after, row, weight)

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
            residuals = self.rows(z, 1) - self._measured[2][:, None]
            for point, r in zip(z, np.ascontiguousarray(residuals.T), strict=True):
                mean, precision = self.normal(point)
                off = point - mean
                costs.append(r @ r + off @ precision @ off)
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
        squares, gradients, hessians = np.empty(len(z)), np.empty_like(z), []
        with np.errstate(all='ignore'):  # the model may diverge
            for i, linear in enumerate(self._linearisations(z, h)):
                mean, precision = self.normal(z[i])
                off, r = z[i] - mean, linear.residual
                pull = precision @ off
                squares[i] = r @ r + off @ pull
                gradients[i] = linear.jacobian.T @ r + pull
                hessians.append(linear.gram + precision)
        return squares, gradients, np.array(hessians)

    def normal(self, point: Array) -> tuple[Array, Array]:
        """Return mean (D,) and precision (D, D) of the prior.

        The mean of a value after a jump is the one before.
        """
        if not self.events:
            return self.prior.mean, self.prior.precision
        event, parameter, after, _, weight = self._placed
        places, prior = self.layout.times, self.prior
        return normal(point, places, event, parameter, after, weight, prior.mean, prior.precision)

    def mean(self, point: Array) -> Array:
        """Return the prior's mean (D,); see `normal`."""
        return self.normal(point)[0]

    def precision(self, point: Array) -> Array:
        """Return the prior's precision (D, D); see `normal`."""
        return self.normal(point)[1]

    def linearisation(self, point: Array, steps: Array) -> Linearisation:
        """Return residual and Jacobian at a point (D,), by forward differences of `steps` (D,)."""
        return next(self._linearisations(point[None], steps[None]))

    def _linearisations(self, points: Array, steps: Array) -> Iterator[Linearisation]:
        """Yield those at points (P, D), by `steps` (P, D), all of one rollout."""
        count, size = points.shape
        moved, columns = np.repeat(points[:, None], size + 1, axis=1), np.arange(size)
        moved[:, 1 + columns, columns] += self._inward(points, steps)
        taken = moved[:, 1 + columns, columns] - points
        states, outputs = self.roll(moved.reshape(-1, size), size + 1)
        grid = self.objective.grid
        shown, end = grid.shown(outputs), states[self._last]
        for i in range(count):
            base, lanes = i * (size + 1), slice(i * (size + 1), (i + 1) * (size + 1))
            own = np.ascontiguousarray(shown[..., lanes])
            residual, jacobian = differences(own, grid.y, grid.weight, grid.period, taken[i])
            yield Linearisation(
                residual=residual,
                jacobian=jacobian,
                state=end[:, base],
                state_jacobian=(end[:, lanes][:, 1:] - end[:, base, None]) / taken[i],
                path=(states[..., base].copy(), outputs[..., base].copy()),
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

    def rows(self, points: Array, width: int | None = None) -> Array:
        """Return the scaled outputs (M, B) of points (B, D) wherever one was measured."""
        mask, weight, _ = self._measured
        outputs = self.roll(points, width)[1]
        return np.asarray(weight * self.objective.grid.shown(outputs)[mask])

    def roll(self, points: Array, width: int | None = None) -> tuple[Array, Array]:
        """Return states (K, n, B) and outputs (K, r, B) of points (B, D).

        Each `width` of them, all if None, are integrated in the steps of the first.
        """
        objective, layout = self.objective, self.layout
        grid, kernels, unknowns = objective.grid, objective.kernels, objective.unknowns
        objective.counter.candidates += len(points)
        x, p = unknowns.values(points[:, : layout.dimension])
        width = len(points) if width is None else width
        if not layout.events:
            states, outputs = kernels.trajectories(grid, x, p, width)
        elif grid.injection is None:
            states, outputs = kernels.scheduled(grid, x, *self._schedule(points, p), width)
        else:
            states, outputs = self._corrected(x, self._schedule(points, p))
        return states, grid.nearest(outputs)

    def _corrected(self, x: Array, schedule: Schedule) -> tuple[Array, Array]:
        """Return states and outputs of rollouts that measurements correct, from states (n, B)."""
        grid, kernels = self.objective.grid, self.objective.kernels
        states = np.empty((grid.t.size, *x.shape))
        outputs = np.empty((grid.t.size, grid.y.shape[1], x.shape[1]))
        first, p = 0, schedule.sets[0]
        for k in np.flatnonzero(schedule.along[:-1] % 2).tolist():  # those in which some jump
            mixed, after = (schedule.sets[schedule.along[k] + i] for i in range(2))
            part = slice(first, k + 1)
            states[part], outputs[part], moved = _run(kernels, grid.stretch(first, k), x, p)
            for row, value in moved:
                mixed[row], after[row] = value, value
            # Measurements at the interval's end correct what comes after it.
            interval, x = grid.uncorrected.stretch(k, k + 1), np.ascontiguousarray(states[k])
            x = kernels.trajectories(interval, x, mixed, x.shape[1])[0][1]
            first, p = k + 1, after
        rest = grid.stretch(first, grid.t.size - 1)
        states[first:], outputs[first:] = kernels.trajectories(rest, x, p, x.shape[1])
        return states, outputs

    def schedule(self, point: Array) -> tuple[Array, IntArray, IntArray]:
        """Return the sets of parameters (S, q) of one point, and which hold where.

        Those are the places of sets between nodes and at nodes (K,).
        """
        p = self.objective.unknowns.values(point[None, : self.layout.dimension])[1]
        if not self.events:
            always = np.zeros(self.nodes, dtype=np.int64)
            return p.T, always, always
        sets, along, there = self._schedule(point[None], p)
        return sets[:, :, 0], along, there

    def _schedule(self, points: Array, p: Array) -> Schedule:
        """Return the sets of parameters of points (B, D), of p (q, B) at the start, and where."""
        event, parameter, after, row, _ = self._placed
        values = self.objective.unknowns.scale.values(points[:, after], parameter).T
        times = self._times(points)
        return Schedule(*scheduled(*times, self._t, event, row, np.ascontiguousarray(values), p))

    def _times(self, points: Array) -> tuple[Array, IntArray]:
        """Return the events' times (E, B), in s from the window's start, and their intervals."""
        # What rounding took off a node is given back.
        shares = np.ascontiguousarray(points[:, self.layout.times])
        return moments(shares, self._t, 4.0 * np.spacing(self._t[-1]))

    def _inward(self, points: Array, steps: Array) -> Array:
        """Return steps (P, D) towards the middle of box and, for a time, of its interval."""
        if self.events:
            t, (times, intervals) = self._t, self._times(points)
            points = points.copy()
            # As if the interval were the box.
            points[:, self.layout.times] = (
                (times - t[intervals]) / (t[intervals + 1] - t[intervals])
            ).T
        return np.where(points > 0.5, -steps, steps)


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
