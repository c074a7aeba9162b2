"""A record laid out for integration: when, with which inputs, against which measurements."""

from dataclasses import dataclass, replace

import numpy as np

from obs_ros.core.interpolation import segments
from obs_ros.core.model import Model
from obs_ros.core.periods import nearest, periods
from obs_ros.core.record import Record
from obs_ros.core.typing import Array, BoolArray, IntArray


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
    the weights are one over the innovations' standard deviations.
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
    injection: Injection | None = None

    @classmethod
    def of(cls, model: Model, record: Record, scale: Array) -> 'Grid':
        """Lay out a record for a model, outputs in units of `scale` (r,).

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
        u, slope = segments(record.t, record.u, kinds)
        mask = np.isfinite(record.y)
        interval = np.diff(record.t) / longest_step(model)
        return cls(
            t=record.t.copy(),
            steps=np.maximum(1, np.ceil(interval)).astype(np.int64),
            u=u,
            slope=slope,
            y=np.where(mask, record.y, 0.0),
            weight=mask / scale,
            measured=np.asarray(mask.any(axis=1)),
            scale=scale,
            period=periods(model.outputs),
        )

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
            injection=injection,
        )

    def measured_values(self, nodes: int) -> int:
        """Count the measured output values at the first `nodes` nodes."""
        return int(np.count_nonzero(self.weight[:nodes]))


def longest_step(model: Model, tolerance: float = 0.01) -> float:
    """Return the longest interval (s) of one step: stamps jitter by some share of `max_step`."""
    return model.max_step * (1.0 + tolerance)
