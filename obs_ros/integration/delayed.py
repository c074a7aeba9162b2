"""Rollouts of models whose delays are estimated: outputs measured, and inputs acting, off in time.

An output stamped t was measured at t - d: the rollout is interpolated there by cubic Hermite
polynomials from states and rates at both ends of each step (Hairer, Norsett & Wanner 1993, II.6),
smooth in d. An input acts late by d: its steps are cut where it changes, see `Pieces`. Each
candidate has delays of its own, which stand among its parameters.
"""

import operator
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any, Protocol

import numpy as np

from obs_ros.core.estimated_delays import is_delay, signal_of
from obs_ros.core.model import Model, names
from obs_ros.core.typing import Array, IntArray
from obs_ros.integration.delayed_outputs import Delayed, nearer, shown, shows_inputs
from obs_ros.integration.grid import Grid
from obs_ros.integration.input_path import Changes, InputPath, Pieces

# Steps between two nodes of a window at whose ends states are kept: of a sample interval that shows
# the plant at all, an eighth is interpolated to 1e-6 of the signal.
PIECES = 8
# Of the median step: so near to changes of the inputs outputs that depend on them show all of them,
# or none, or those that were before, whichever is nearest to what was measured. A dead time of a
# whole number of samples puts every change at a sample, where an output would leap with the dead
# time; so leaps come only where that is ruled out, by more than a dead time's usual deviation.
SLACK = 0.25


class DelayedRollouts(Protocol):
    """Rollouts of one backend for delays."""

    model: Model
    compile_time: float

    @property
    def name(self) -> str:
        """The backend's name."""

    def restarted(self, grid: Grid, states: Array, p: Array) -> Array:
        """See `Kernels.restarted`."""

    def delayed(self, window: Delayed, x0: Array, p: Array) -> tuple[Array, Array]:
        """Return states (K, n, B) and outputs (S, K, r, B) of candidates; 0 where not wanted.

        p (S, q, B) are the sets of parameters.
        """


@dataclass(frozen=True)
class _Steps:
    """The steps of a grid, from t[f] to t[f + 1] of t (F,) in s since its first node.

    See `Delayed`. They lie in the `interval` (F - 1,) from a node to the next, but for one beyond
    the last node, in which inputs may change that were measured by then. `changes` are those of the
    inputs that are late, by column.
    """

    t: Array
    steps: IntArray
    interval: IntArray
    at: IntArray
    u: Array
    slope: Array
    changes: dict[int, Changes]

    @classmethod
    def of(cls, grid: Grid, late: Iterable[int]) -> '_Steps':
        pieces = np.minimum(grid.steps, PIECES)
        node = np.repeat(np.arange(pieces.size), pieces)
        at = np.append(0, np.cumsum(pieces))
        h = np.diff(grid.t) / pieces
        after = np.append(h[node] * (np.arange(node.size) - at[node]), [0.0, np.median(h)])
        interval, node = np.append(node, node[-1]), np.append(node, [pieces.size, pieces.size])
        path = grid.path or InputPath(grid.t, grid.u, grid.slope)
        path = replace(path, t=path.t - grid.t[0])
        return cls(
            t=grid.t[node] - grid.t[0] + after,
            steps=-(-grid.steps[interval] // pieces[interval]),
            interval=interval,
            at=at,
            u=grid.u[node] + after[:, None] * grid.slope[node],
            slope=grid.slope[node],
            changes={column: path.changes(column) for column in late},
        )


class DelayedKernels:
    """Rolls candidates out whose last parameters are delays; see `Kernels` for the methods."""

    own_steps = False

    def __init__(self, rollouts: DelayedRollouts) -> None:
        self._rollouts = rollouts
        self.model = model = rollouts.model
        self.name, self.compile_time = rollouts.name, rollouts.compile_time
        rows = {signal_of(v.name): i for i, v in enumerate(model.parameters) if is_delay(v.name)}
        self._inputs, self._outputs = (
            [(i, rows[v.name]) for i, v in enumerate(group) if isinstance(v.delay, tuple)]
            for group in (model.inputs, model.outputs)
        )
        self._slack = SLACK * np.array([0.0, 1.0, -1.0] if shows_inputs(model) else [0.0])
        self._last: tuple[Array, Array, IntArray, _Steps] | None = None

    def squares(self, grid: Grid, prefixes: IntArray, x0: Array, p: Array) -> Array:
        """See `Kernels.squares`."""
        outputs = shown(grid, self._rolled(grid, int(prefixes[-1]), x0, p[None])[1])
        known = grid.weight[: len(outputs)] > 0.0
        off = grid.weight[: len(outputs), :, None] * (outputs - grid.y[: len(outputs), :, None])
        squared = np.where(known[:, :, None], off * off, 0.0)
        blocks = zip(np.append(0, prefixes[:-1]), prefixes, strict=True)
        return np.array([squared[first:last].sum(axis=0) for first, last in blocks])

    def grams(self, grid: Grid, nodes: int, x0: Array, p: Array, width: int) -> Array:
        """See `Kernels.grams`."""
        outputs = shown(grid, self._rolled(grid, nodes, x0, p[None], width=width)[1])
        known = grid.weight[:nodes] > 0.0
        weight = grid.weight[:nodes][known]
        starts = p.shape[1] // width
        lanes = weight[:, None, None] * outputs[known].reshape(weight.size, starts, width)
        rows = lanes - lanes[:, :, :1]
        rows[:, :, 0] = lanes[:, :, 0] - (weight * grid.y[:nodes][known])[:, None]
        return np.asarray(rows.transpose(1, 2, 0) @ rows.transpose(1, 0, 2))

    def trajectories(self, grid: Grid, x0: Array, p: Array, width: int = 1) -> tuple[Array, Array]:
        """See `Kernels.trajectories`; all take the steps of the grid."""
        return self._rolled(grid, grid.t.size, x0, p[None], everywhere=True)

    def counts(self, grid: Grid, x0: Array, p: Array) -> IntArray:
        """See `Kernels.counts`."""
        return np.repeat(grid.steps[:, None], x0.shape[1], axis=1)

    def restarted(self, grid: Grid, states: Array, p: Array) -> Array:
        """See `Kernels.restarted`; the inputs are as they come, not as late as they act."""
        return self._rollouts.restarted(grid, states, p)

    def paths(self, grid: Grid, x0: Array, p: Array) -> tuple[Array, Array, Array]:
        """See `Kernels.paths`."""
        states, outputs = self.trajectories(grid, x0, p)
        return states, np.repeat(p[None], grid.t.size, axis=0), outputs

    def scheduled(
        self, grid: Grid, x0: Array, p: Array, along: IntArray, there: IntArray, width: int = 1
    ) -> tuple[Array, Array]:
        """Return states (K, n, B) and outputs (K, r, B) under parameters that change.

        Of the sets p (S, q, B) the one between two nodes is along[k] (K - 1,), that at a node
        there[k] (K,). Delays are those of the first set; all take the grid's steps.
        """
        return self._rolled(grid, grid.t.size, x0, p, everywhere=True, order=(along, there))

    def one_step(self, *_: Any) -> Any:
        """Refuse: one step does not lead from sample to sample."""
        raise ValueError(f'model {self.model.name!r}: its samples are off in time')

    def filter(self, *_: Any) -> Any:
        """Refuse: a filter goes from sample to sample, and these are off in time."""
        raise ValueError(f'model {self.model.name!r}: no filter takes a delay that is estimated')

    def _rolled(
        self,
        grid: Grid,
        nodes: int,
        x0: Array,
        p: Array,
        *,
        everywhere: bool = False,
        width: int = 1,
        order: tuple[IntArray, IntArray] | None = None,
    ) -> tuple[Array, Array]:
        """Return states (K, n, B) and outputs (K, r, B) at the first `nodes` nodes.

        Of `width` neighbouring candidates the outputs are as the first of them needs it.
        """
        assert grid.injection is None, 'process noise goes without estimated delays'
        steps, delays = self._steps(grid), p[0]
        offset = np.zeros((len(self.model.outputs), x0.shape[1]))
        late = np.zeros(len(offset), dtype=np.bool_)
        for output, row in self._outputs:
            offset[output], late[output] = delays[row], True
        end = grid.t[nodes - 1] - grid.t[0] - min(0.0, float(offset.min()))
        last = max(int(np.searchsorted(steps.t, end)), int(steps.at[nodes - 1])) + 2
        part = slice(min(last, steps.t.size))
        pieces, u, slope = self._driven(steps, part, delays)
        step = np.repeat(np.arange(part.stop - 1), np.diff(pieces.first))
        along, there = order or np.zeros((2, grid.t.size), dtype=np.int64)
        wanted = grid.weight[:nodes] > 0.0
        window = Delayed(
            float(grid.clock[0]), pieces.t, steps.steps[step], pieces.first[steps.at[:nodes]],
            u, slope, along[steps.interval[step]], there[:nodes], offset, late,
            np.ones_like(wanted) if everywhere else wanted,
            self._slack * np.median(np.diff(steps.t)),
        )  # fmt: skip
        states, outputs = self._rollouts.delayed(window, x0, p)
        return states, outputs[0] if len(outputs) == 1 else nearer(grid, outputs, width)

    def _driven(self, steps: _Steps, part: slice, p: Array) -> tuple[Pieces, Array, Array]:
        """Return pieces, with values and slopes of the inputs (F, m, B) from each beginning on."""
        t = steps.t[part]
        late = [steps.changes[column].t[1:, None] + p[row] for column, row in self._inputs]
        pieces = Pieces.of(t, late, p.shape[1])
        step = np.append(np.repeat(np.arange(t.size - 1), np.diff(pieces.first)), t.size - 1)
        slope = np.repeat(steps.slope[step, :, None], p.shape[1], axis=2)
        u = steps.u[step, :, None] + (pieces.t - t[step, None])[:, None] * slope
        for (column, row), changed in zip(self._inputs, pieces.changed, strict=True):
            own = steps.changes[column].after(changed, pieces.t - p[row])
            u[:, column], slope[:, column] = own
        return pieces, u, slope

    def _steps(self, grid: Grid) -> _Steps:
        """Return the steps of a grid; those of one window are asked for again and again."""
        last = self._last
        if last is not None and all(map(operator.is_, last, (grid.t, grid.u, grid.steps))):
            return last[3]
        steps = _Steps.of(grid, [column for column, _ in self._inputs])
        self._last = grid.t, grid.u, grid.steps, steps
        return steps


def delay_names(model: Model) -> tuple[str, ...]:
    """Return the names of the parameters that are delays."""
    return tuple(name for name in names(model.parameters) if is_delay(name))
