"""A record laid out for integration: when, with which inputs, against which measurements."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from obs_ros.core.changes import replace
from obs_ros.core.interpolation import segments
from obs_ros.core.model import Interpolation, Model, Variable
from obs_ros.core.periods import nearest, periods
from obs_ros.core.record import Record
from obs_ros.core.saturation import Ends, applied, ends_of
from obs_ros.core.typing import Array, BoolArray, IntArray
from obs_ros.integration.input_path import InputPath

SAME_TIME = 1e-6  # s: stamps since 1970 as floats are no finer
SAME_INPUT = 1e-9  # of its range in a window: by less no input leaps
# What rollouts depend on, but for what corrects them.
ROLLED = ('t', 'steps', 'u', 'slope', 'y', 'period', 'injection', 'origin', 'path', 'tolerance')
TIGHTER = 0.1  # of a tolerance: errors of the finer one count for nothing beside those of the other


@dataclass(frozen=True)
class Injection:
    """Gains that do not depend on the candidate, by which measurements correct every rollout.

    At node k the outputs y_i that were measured correct the predicted state one after the other,
    with the model's outputs h evaluated once, at the prediction:

        e_i = y_i - h_i(x) - sum over j < i of cross[k, i, j] e_j;    x <- x + gain[k, i] e_i

    gain (K, r, n + q), in units of the variable per unit of the output, and cross (K, r, r), the
    effect C_i K_j of the update by output j on output i, are 0 where nothing was measured. Of a
    gain's last q entries only those of the parameters `moving` (w,) differ from 0: these are states
    without dynamics. Anderson & Moore 1979, section 6.4, for updates in sequence.
    """

    gain: Array
    cross: Array
    moving: IntArray


@dataclass(frozen=True)
class Grid:
    """The nodes of a window.

    t (K,) in s; steps (K-1,) integration steps from each node to the next; the input at node k plus
    s seconds is u[k] + s * slope[k], with u and slope (K, m); y (K, r) measured outputs with 0
    where nothing was measured; weight (K, r) one over the output's scale, 0 where not measured;
    scale (r,) those scales; measured (K,) whether a node has any measured output; period (r,) the
    outputs' periods, 0 for those without: residuals go by the shortest way round. With an injection
    the weights are one over the innovations' standard deviations. `ends` are those that saturated
    sensors show, whose y are exactly these; None where no sensor has a range. rounding (r,) is the
    standard deviation of the errors by which sensors round, 0 where that is not known.
    A linearly implicit method lets candidates take steps of their own where `tolerance`, of their
    local errors, is above 0 (see `own_steps.py`): `budget` in all and `longest` s each at most.
    The model's own time counts from `origin` s. `path` are the inputs of a model that estimates how
    late they act, since before the window. `discrete` says that steps are those of a discrete
    model, one a period.
    """

    t: Array
    steps: IntArray
    u: Array
    slope: Array
    y: Array
    weight: Array
    measured: BoolArray
    scale: Array
    period: Array
    rounding: Array
    ends: Ends | None = None
    injection: Injection | None = None
    origin: float = 0.0
    path: InputPath | None = None
    discrete: bool = False
    tolerance: float = 0.0
    budget: int = 0
    longest: float = math.inf

    @classmethod
    def of(cls, model: Model, record: Record, scale: Array, start: float | None = None) -> 'Grid':
        """Lay out a record for a model, outputs in units of `scale` (r,).

        `start` (s) is where the window begins that the record belongs to, if not at its first node.
        Where an output may have been measured outside of the window, by its delay that is to be
        estimated, it counts as not measured.

        Raises ValueError when the record has other numbers of inputs or outputs than the model.
        """
        for what, columns, variables in (
            ('u', record.u.shape[1], model.inputs),
            ('y', record.y.shape[1], model.outputs),
        ):
            if columns != len(variables):
                raise ValueError(
                    f'the record has {columns} columns in {what}, '
                    f'but model {model.name!r} has {len(variables)}: '
                    f'{[variable.name for variable in variables]}'
                )
        kinds = [variable.interpolation for variable in model.inputs]
        u, slope = segments(record.t, applied(model.inputs, record.u), kinds)
        ends = ends_of(model.outputs, record.y)
        mask = np.isfinite(record.y) & _inside(model, record.t)
        y = record.y if ends is None else ends.measured(record.y)
        return cls(
            t=record.t.copy(),
            steps=steps_within(model, np.diff(record.t)),
            u=u,
            slope=slope,
            y=np.where(mask, y, 0.0),
            weight=mask / scale,
            measured=np.asarray(mask.any(axis=1)),
            scale=scale,
            period=periods(model.outputs),
            rounding=np.array([variable.rounding for variable in model.outputs]),
            ends=ends,
            origin=0.0 if model.time == 'stamp' else float(record.t[0]) if start is None else start,
            path=_path(model, record, kinds) if any(map(is_estimated, model.inputs)) else None,
            discrete=model.kind == 'discrete',
            longest=longest_step(model),
        )

    @cached_property
    def clock(self) -> Array:
        """The model's own time (K,) in s at the nodes."""
        return self.t - self.origin if self.origin else self.t

    @cached_property
    def fresh(self) -> BoolArray:
        """Whether inputs leap where an interval begins (K - 1,); at the first they count as so."""
        dt, moved = np.diff(self.t)[:, None], np.ptp(self.u, axis=0)
        leaps = np.abs(self.u[1:] - self.u[:-1] - self.slope[:-1] * dt) > SAME_INPUT * moved
        return np.append(True, leaps.any(axis=1))[: self.t.size - 1]

    def stepped(self, steps: IntArray) -> 'Grid':
        """Return the same grid with other integration steps (K - 1,) between its nodes."""
        return replace(self, steps=steps)

    @property
    def is_free(self) -> bool:
        """Whether candidates may take steps of their own: none corrects them."""
        return self.tolerance > 0.0 and self.injection is None

    def rolls_like(self, other: 'Grid') -> bool:
        """Whether candidates roll out as on another grid, from which this was made.

        They do in other scales, unless measurements correct them or they take steps of their own.
        """
        if self is other:
            return True
        if self.injection is not None or self.tolerance > 0.0:
            return False
        return all(getattr(self, name) is getattr(other, name) for name in ROLLED)

    def like(self, other: 'Grid') -> 'Grid':
        """Return the same grid in the steps of another one with these nodes."""
        return replace(self, steps=other.steps, tolerance=other.tolerance, budget=other.budget)

    def finer(self) -> 'Grid':
        """Return the same grid with twice the steps, and candidates' own much finer."""
        own = {'tolerance': TIGHTER * self.tolerance, 'budget': 4 * self.budget}
        return replace(self, steps=2 * self.steps, **own)

    def rescaled(self, factor: Array) -> 'Grid':
        """Return the same grid with the outputs' scales (r,) multiplied by `factor` (r,).

        Gains stay: noise and process noise grow together.
        """
        return replace(self, weight=self.weight / factor, scale=self.scale * factor)

    def injected(self, injection: Injection, S: Array) -> 'Grid':
        """Return the same grid with rollouts corrected, for innovations of variance S (K, r).

        The scales stay those of the outputs, the weights become one over the root of S.
        """
        weight = np.divide(1.0, np.sqrt(S), out=np.zeros_like(S), where=self.weight > 0.0)
        return replace(self, weight=weight, injection=injection)

    def without(self, samples: BoolArray) -> 'Grid':
        """Return the same grid, not corrected, with some samples (K, r) taken as not measured."""
        weight = np.where(samples, 0.0, self.weight)
        measured = np.asarray((weight > 0.0).any(axis=1))
        y = np.where(samples, 0.0, self.y)
        return replace(self, y=y, weight=weight, measured=measured, injection=None)

    @property
    def uncorrected(self) -> 'Grid':
        """The same grid without an injection; its weights stay."""
        return replace(self, injection=None)

    @property
    def values(self) -> Array:
        """Measured outputs (K, r), NaN where nothing was measured or the sensor is saturated."""
        known = self.weight > 0.0
        known = known if self.ends is None else known & ~self.ends.saturated
        return np.where(known, self.y, np.nan)

    def shown(self, outputs: Array) -> Array:
        """Return outputs (K, r) or (K, r, B) as sensors show them where these are saturated."""
        return outputs if self.ends is None else self.ends.shown(outputs)

    def residuals(self, outputs: Array) -> Array:
        """Return the scaled residuals (K, r) of outputs (K, r).

        NaN = not measured, or saturated with the output at that end or beyond.
        """
        weight = np.where(self.weight > 0, self.weight, np.nan)
        residuals = weight * (self.shown(outputs) - self.y)
        if self.ends is not None:
            residuals[self.ends.beyond(outputs)] = np.nan
        return np.asarray(residuals)

    def nearest(self, outputs: Array) -> Array:
        """Return outputs (K, r) or (K, r, B), whole periods away, nearest those measured."""
        if not self.period.any():
            return outputs
        if outputs.ndim == 2:
            return nearest(outputs, self.y, self.period)
        return nearest(outputs, self.y[:, :, None], self.period[:, None])

    @property
    def straight(self) -> 'Grid':
        """The same grid with residuals as they are, not by the shortest way round."""
        return replace(self, period=np.zeros_like(self.period))

    def unscaled(self, residuals: Array) -> Array:
        """Return scaled residuals (K, r) in the outputs' units; NaN = not measured."""
        if self.injection is None:
            return residuals * self.scale
        with np.errstate(divide='ignore', invalid='ignore'):
            return residuals / self.weight

    def stretch(self, first: int, last: int) -> 'Grid':
        """Return the nodes from `first` to `last`, both included."""
        nodes, intervals = slice(first, last + 1), slice(first, last)
        injection = self.injection
        if injection is not None:
            injection = Injection(injection.gain[nodes], injection.cross[nodes], injection.moving)
        return replace(
            self,
            t=self.t[nodes],
            steps=self.steps[intervals],
            u=self.u[nodes],
            slope=self.slope[nodes],
            y=self.y[nodes],
            weight=self.weight[nodes],
            measured=self.measured[nodes],
            ends=None if self.ends is None else self.ends[nodes],
            injection=injection,
        )

    def measured_values(self, nodes: int) -> int:
        """Count the measured output values at the first `nodes` nodes.

        A saturated one is no value, but a bound.
        """
        return int(self._values_before[nodes])

    @cached_property
    def _values_before(self) -> IntArray:
        """How many output values were measured before each node, and in all (K + 1,)."""
        known = self.weight > 0.0
        known = known if self.ends is None else known & ~self.ends.saturated
        return np.concatenate([[0], np.cumsum(np.count_nonzero(known, axis=1))])


def _inside(model: Model, t: Array) -> BoolArray | bool:
    """Whether each output (K, r) was surely measured between the first and last of t (K,)."""
    if not any(map(is_estimated, model.outputs)):
        return True
    delays = [v.delay if isinstance(v.delay, tuple) else (0.0, 0.0) for v in model.outputs]
    lower, upper = np.array(delays).T
    after = t[:, None] - upper >= t[0] - SAME_TIME
    return np.asarray(after & (t[:, None] - lower <= t[-1] + SAME_TIME))


def _path(model: Model, record: Record, kinds: Sequence[Interpolation]) -> InputPath:
    """Return the inputs of a record, and what it has of them before its start."""
    t, u = record.t, record.u
    if record.past is not None:
        before, values = record.past
        t, u = np.concatenate([before, t[1:]]), np.concatenate([values, u[1:]])
    return InputPath(t, *segments(t, applied(model.inputs, u), kinds))


def is_estimated(variable: Variable) -> bool:
    """Whether the delay of an input or output is to be estimated."""
    return isinstance(variable.delay, tuple)


def usual_step(model: Model, grid: Grid) -> float:
    """Return the mean step (s) of a grid; `max_step` where nothing asked for finer ones."""
    if math.isfinite(model.max_step) and np.array_equal(
        grid.steps, steps_within(model, np.diff(grid.t))
    ):
        return model.max_step
    return float((grid.t[-1] - grid.t[0]) / grid.steps.sum())


def longest_step(model: Model, tolerance: float = 0.01) -> float:
    """Return the longest interval (s) of one step: stamps jitter by some share of `max_step`."""
    return model.max_step * (1.0 + tolerance)


def steps_within(model: Model, intervals: Array) -> IntArray:
    """Return the steps (K,) that a model takes over intervals (K,) in s, one at least.

    They are as long as `longest_step` at most. A discrete model takes one a period: between nodes
    that clocks have moved by less than half of it, the nearest number.
    """
    if model.period is not None:
        return np.maximum(1, np.rint(intervals / model.period)).astype(np.int64)
    return np.maximum(1, np.ceil(intervals / longest_step(model))).astype(np.int64)
