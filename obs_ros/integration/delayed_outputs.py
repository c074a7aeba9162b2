"""Outputs of models whose delays are estimated, from states along a window and the inputs there."""

from typing import NamedTuple

import numpy as np

from obs_ros.core.model import Model, Variable, inside
from obs_ros.core.periods import nearest
from obs_ros.core.typing import Array, BoolArray, IntArray
from obs_ros.integration.grid import Grid

TRIED = 20  # points at which an output is asked whether it depends on inputs


class Delayed(NamedTuple):
    """A window for B candidates with delays.

    Step f of a candidate goes from t[f] to t[f + 1], of t (F, B) in s since the first node, at the
    model's own time `start`, in steps[f] integration steps; s seconds into it the inputs are u[f] +
    s slope[f], with u and slope (F, m, B). Node k of the window's K is at t[at[k]]. Of several sets
    of parameters the one of a step is along[f] (F - 1,), that of a node there[k] (K,). offset
    (r, B) says how many s before its stamp an output was measured, `late` (r,) which outputs are
    off at all, `wanted` (K, r) at which nodes an output is asked for. Of the S sets of outputs each
    shows the inputs from changes on that are less than slack[S] s away, or, where that is negative,
    until after changes that were less ago.
    """

    start: float
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
    slack: Array

    @property
    def clock(self) -> Array:
        """The model's own time (F, B) in s at the ends of the steps."""
        return self.start + self.t

    def begun(self, f: IntArray, place: IntArray) -> Array:
        """Return when the steps f of candidates `place` begin."""
        return np.asarray(self.t[np.minimum(f, len(self.t) - 1), place])

    def shown(self, f: IntArray, place: IntArray, s: Array, slack: float) -> tuple[Array, ...]:
        """Return the inputs that outputs show, s seconds into the steps f of candidates `place`."""
        at, last = self.t[f, place] + s, len(self.t) - 1
        chosen = f
        while (later := (chosen < last) & (self.begun(chosen + 1, place) < at + slack)).any():
            chosen = chosen + later
        while (sooner := (chosen > 0) & (self.begun(chosen, place) > at + slack)).any():
            chosen = chosen - sooner
        s = at - self.t[chosen, place]
        rows = range(self.u.shape[1])
        return tuple(self.u[chosen, j, place] + s * self.slope[chosen, j, place] for j in rows)


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


def outputs_at(model: Model, window: Delayed, tracks: Tracks, p: Array) -> Array:
    """Return the outputs (S, K, r, B) of candidates, by the states and rates of every step."""
    t, place = window.t, np.arange(p.shape[2])
    outputs = np.zeros((window.slack.size, window.at.size, len(window.offset), place.size))
    for i in range(len(window.offset)):
        node = np.flatnonzero(window.wanted[:, i])
        f = np.repeat(window.at[node, None], place.size, axis=1)
        x = [tracks.states[f, j, place] for j in range(tracks.states.shape[1])]
        at, s, chosen = t[f, place], np.zeros(f.shape), window.there[node, None]
        if window.late[i]:
            at = at - window.offset[i]
            for lane in place:
                f[:, lane] = np.searchsorted(t[:, lane], at[:, lane], side='right') - 1
            f = np.clip(f, 0, len(t) - 2)
            s, chosen = at - t[f, place], window.along[f]
            h = t[f + 1, place] - t[f, place]
            x = [tracks.between(j, f, place, s, h) for j in range(len(x))]
        parameters = tuple(p[chosen, j, place] for j in range(p.shape[1]))
        for side, slack in enumerate(window.slack):
            u = window.shown(f, place, s, slack)
            y = model.output(window.start + at, tuple(x), u, parameters)[i]
            outputs[side, node, i] = y
    return outputs


def nearer(grid: Grid, outputs: Array, width: int) -> Array:
    """Return of outputs (S, K, r, B) those nearest to what was measured, candidate by candidate."""
    weight, y = (each[: outputs.shape[1], :, None] for each in (grid.weight, grid.y))
    squares = [
        np.square(np.where(weight > 0.0, weight * (shown(grid, each) - y), 0.0)).sum(axis=(0, 1))
        for each in outputs
    ]
    best = np.argmin(squares, axis=0)
    best = best[np.arange(best.size) // width * width]
    return np.asarray(np.take_along_axis(outputs, best[None, None, None], axis=0)[0])


def shown(grid: Grid, outputs: Array) -> Array:
    """Return outputs (K, r, B) at the first nodes as sensors that wrap or saturate show them."""
    outputs = nearest(outputs, grid.y[: len(outputs), :, None], grid.period[:, None])
    return outputs if grid.ends is None else grid.ends[: len(outputs)].shown(outputs)


def shows_inputs(model: Model) -> bool:
    """Whether outputs depend on inputs, as tried at some points."""
    rng = np.random.default_rng(0)

    def drawn(variables: tuple[Variable, ...]) -> tuple[Array, ...]:
        middle = [inside(variable) for variable in variables]
        return tuple(m + max(1.0, abs(m)) * rng.uniform(-1.0, 1.0, TRIED) for m in middle)

    x, p = drawn(tuple(model.states)), tuple(np.full(TRIED, inside(v)) for v in model.parameters)
    one, other = drawn(tuple(model.inputs)), drawn(tuple(model.inputs))
    with np.errstate(all='ignore'):
        pairs = zip(*(model.output(0.0, x, u, p) for u in (one, other)), strict=True)
        off = [np.subtract(a, b, dtype=np.float64) for a, b in pairs]
    return any(bool((np.isfinite(each) & (each != 0.0)).any()) for each in off)
