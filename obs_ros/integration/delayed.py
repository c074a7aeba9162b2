"""Rollouts of models whose delays are estimated: outputs measured, and inputs acting, off in time.

An output stamped t was measured at t - d: the rollout is interpolated there by cubic Hermite
polynomials from states and rates at both ends of each step (Hairer, Norsett & Wanner 1993, II.6),
smooth in d. An input acts late by d: see `InputPath`. Each candidate has delays of its own, which
stand among its parameters.
"""

import operator
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

import numpy as np

from obs_ros.core.estimated_delays import is_delay, signal_of
from obs_ros.core.model import Model, names
from obs_ros.core.periods import nearest
from obs_ros.core.typing import Array, BoolArray, IntArray
from obs_ros.integration.grid import Grid
from obs_ros.integration.input_path import InputPath

# Steps between two nodes of a window at whose ends states are kept: of a sample interval that shows
# the plant at all, an eighth is interpolated to 1e-6 of the signal.
PIECES = 8


class Delayed(NamedTuple):
    """A window for B candidates with delays.

    Step f goes from t[f] to t[f + 1], of the model's own time t (F,) in s, in steps[f] integration
    steps; s seconds into it the inputs are u[f] + s slope[f], with u and slope (F, m, B). Node k of
    the window's K is at t[at[k]]. Of several sets of parameters the one of a step is along[f]
    (F - 1,), that of a node there[k] (K,). offset (r, B) says how many s before its stamp an output
    was measured, `late` (r,) which outputs are off at all, `wanted` (K, r) at which nodes an output
    is asked for.
    """

    t: Array
    steps: IntArray
    at: IntArray
    u: Array
    slope: Array
    along: IntArray
    there: IntArray
    offset: Array
    late: BoolArray
    wanted: BoolArray

    @property
    def clock(self) -> Array:
        """The model's own time (F,) in s at the ends of the steps: that of `t`."""
        return self.t


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
        """Return states (K, n, B) and outputs (K, r, B) of candidates; 0 where not wanted.

        p (S, q, B) are the sets of parameters.
        """


@dataclass(frozen=True)
class _Steps:
    """The steps of a grid, and the intervals (F - 1,) in which they lie; see `Delayed`."""

    t: Array
    steps: IntArray
    interval: IntArray
    at: IntArray
    u: Array
    slope: Array
    path: InputPath

    @classmethod
    def of(cls, grid: Grid) -> '_Steps':
        pieces = np.minimum(grid.steps, PIECES)
        node = np.repeat(np.arange(pieces.size), pieces)
        at = np.append(0, np.cumsum(pieces))
        h = np.diff(grid.t) / pieces
        after = h[node] * (np.arange(node.size) - at[node])
        node, after = np.append(node, grid.t.size - 1), np.append(after, 0.0)
        return cls(
            t=grid.t[node] + after,
            steps=-(-grid.steps[node[:-1]] // pieces[node[:-1]]),
            interval=node[:-1],
            at=at,
            u=grid.u[node] + after[:, None] * grid.slope[node],
            slope=grid.slope[node],
            path=grid.path or InputPath(grid.t, grid.u, grid.slope),
        )


class DelayedKernels:
    """Rolls candidates out whose last parameters are delays; see `Kernels` for the methods."""

    def __init__(self, rollouts: DelayedRollouts) -> None:
        self._rollouts = rollouts
        self.model = model = rollouts.model
        self.name, self.compile_time = rollouts.name, rollouts.compile_time
        rows = {signal_of(v.name): i for i, v in enumerate(model.parameters) if is_delay(v.name)}
        self._inputs, self._outputs = (
            [(i, rows[v.name]) for i, v in enumerate(group) if isinstance(v.delay, tuple)]
            for group in (model.inputs, model.outputs)
        )
        self._last: tuple[Array, Array, IntArray, _Steps] | None = None

    def squares(self, grid: Grid, prefixes: IntArray, x0: Array, p: Array) -> Array:
        """See `Kernels.squares`."""
        outputs = _shown(grid, self._rolled(grid, int(prefixes[-1]), x0, p[None])[1])
        known = grid.weight[: len(outputs)] > 0.0
        off = grid.weight[: len(outputs), :, None] * (outputs - grid.y[: len(outputs), :, None])
        squared = np.where(known[:, :, None], off * off, 0.0)
        blocks = zip(np.append(0, prefixes[:-1]), prefixes, strict=True)
        return np.array([squared[first:last].sum(axis=0) for first, last in blocks])

    def grams(self, grid: Grid, nodes: int, x0: Array, p: Array, width: int) -> Array:
        """See `Kernels.grams`."""
        outputs = _shown(grid, self._rolled(grid, nodes, x0, p[None])[1])
        known = grid.weight[:nodes] > 0.0
        weight = grid.weight[:nodes][known]
        starts = p.shape[1] // width
        lanes = weight[:, None, None] * outputs[known].reshape(weight.size, starts, width)
        rows = lanes - lanes[:, :, :1]
        rows[:, :, 0] = lanes[:, :, 0] - (weight * grid.y[:nodes][known])[:, None]
        return np.asarray(rows.transpose(1, 2, 0) @ rows.transpose(1, 0, 2))

    def trajectories(self, grid: Grid, x0: Array, p: Array) -> tuple[Array, Array]:
        """See `Kernels.trajectories`."""
        return self._rolled(grid, grid.t.size, x0, p[None], everywhere=True)

    def restarted(self, grid: Grid, states: Array, p: Array) -> Array:
        """See `Kernels.restarted`; the inputs are as they come, not as late as they act."""
        return self._rollouts.restarted(grid, states, p)

    def paths(self, grid: Grid, x0: Array, p: Array) -> tuple[Array, Array, Array]:
        """See `Kernels.paths`."""
        states, outputs = self.trajectories(grid, x0, p)
        return states, np.repeat(p[None], grid.t.size, axis=0), outputs

    def scheduled(
        self, grid: Grid, x0: Array, p: Array, along: IntArray, there: IntArray
    ) -> tuple[Array, Array]:
        """Return states (K, n, B) and outputs (K, r, B) under parameters that change.

        Of the sets p (S, q, B) the one between two nodes is along[k] (K - 1,), that at a node
        there[k] (K,). Delays are those of the first set.
        """
        return self._rolled(grid, grid.t.size, x0, p, everywhere=True, order=(along, there))

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
        order: tuple[IntArray, IntArray] | None = None,
    ) -> tuple[Array, Array]:
        """Return states (K, n, B) and outputs (K, r, B) at the first `nodes` nodes."""
        assert grid.injection is None, 'process noise goes without estimated delays'
        steps, delays = self._steps(grid), p[0]
        offset = np.zeros((len(self.model.outputs), x0.shape[1]))
        late = np.zeros(len(offset), dtype=np.bool_)
        for output, row in self._outputs:
            offset[output], late[output] = delays[row], True
        end = grid.t[nodes - 1] - min(0.0, float(offset.min()))
        last = max(int(np.searchsorted(steps.t, end)), int(steps.at[nodes - 1])) + 1
        part = slice(max(2, min(last, steps.t.size)))
        u, slope = self._driven(steps, part, delays)
        along, there = order or np.zeros((2, grid.t.size), dtype=np.int64)
        wanted = grid.weight[:nodes] > 0.0
        window = Delayed(
            steps.t[part] - grid.origin, steps.steps[: part.stop - 1], steps.at[:nodes], u, slope,
            along[steps.interval[: part.stop - 1]], there[:nodes], offset, late,
            np.ones_like(wanted) if everywhere else wanted,
        )  # fmt: skip
        return self._rollouts.delayed(window, x0, p)

    def _driven(self, steps: _Steps, part: slice, p: Array) -> tuple[Array, Array]:
        """Return values and slopes of the inputs (F, m, B) from each step's beginning on."""
        u, slope = (
            np.repeat(each[part, :, None], p.shape[1], axis=2) for each in (steps.u, steps.slope)
        )
        for column, row in self._inputs:
            u[:, column], slope[:, column] = steps.path.shifted(column, steps.t[part], p[row])
        return u, slope

    def _steps(self, grid: Grid) -> _Steps:
        """Return the steps of a grid; those of one window are asked for again and again."""
        last = self._last
        if last is not None and all(map(operator.is_, last, (grid.t, grid.u, grid.steps))):
            return last[3]
        steps = _Steps.of(grid)
        self._last = grid.t, grid.u, grid.steps, steps
        return steps


class Tracks(NamedTuple):
    """States (F, n, B) at the ends of all steps, rates (F - 1, n, B) where each begins and ends."""

    states: Array
    begin: Array
    end: Array

    def between(self, j: int, f: IntArray, place: IntArray, s: Array, h: Array) -> Array:
        """Return state j, s seconds into the steps f of h seconds, of the candidates `place`.

        Before a step and after it states go on straight.
        """
        a = np.clip(s / h, 0.0, 1.0)
        b = 1.0 - a
        return np.asarray(
            b * b * (1.0 + 2.0 * a) * self.states[f, j, place]
            + a * a * (1.0 + 2.0 * b) * self.states[f + 1, j, place]
            + (b * b * a * h + np.minimum(s, 0.0)) * self.begin[f, j, place]
            + (np.maximum(s - h, 0.0) - a * a * b * h) * self.end[f, j, place]
        )


def _shown(grid: Grid, outputs: Array) -> Array:
    """Return outputs (K, r, B) at the first nodes as sensors that wrap or saturate show them."""
    outputs = nearest(outputs, grid.y[: len(outputs), :, None], grid.period[:, None])
    return outputs if grid.ends is None else grid.ends[: len(outputs)].shown(outputs)


def outputs_at(model: Model, window: Delayed, tracks: Tracks, p: Array) -> Array:
    """Return the outputs (K, r, B) of candidates, by the states and rates of every step."""
    t, place = window.t, np.arange(p.shape[2])
    outputs = np.zeros((window.at.size, len(window.offset), place.size))
    for i in range(len(window.offset)):
        node = np.flatnonzero(window.wanted[:, i])
        f = np.repeat(window.at[node, None], place.size, axis=1)
        x = [tracks.states[f, j, place] for j in range(tracks.states.shape[1])]
        at, s, chosen = t[f], np.zeros(f.shape), window.there[node, None]
        if window.late[i]:
            at = at - window.offset[i]
            f = np.clip(np.searchsorted(t, at, side='right') - 1, 0, t.size - 2)
            s, chosen = at - t[f], window.along[f]
            x = [tracks.between(j, f, place, s, t[f + 1] - t[f]) for j in range(len(x))]
        u = [
            window.u[f, j, place] + s * window.slope[f, j, place] for j in range(window.u.shape[1])
        ]
        parameters = tuple(p[chosen, j, place] for j in range(p.shape[1]))
        outputs[node, i] = model.output(at, tuple(x), tuple(u), parameters)[i]
    return outputs


def delay_names(model: Model) -> tuple[str, ...]:
    """Return the names of the parameters that are delays."""
    return tuple(name for name in names(model.parameters) if is_delay(name))
