"""One window with all that is known before it is fitted."""

from dataclasses import dataclass

import numpy as np

from obs_ros.core.changes import replace
from obs_ros.core.record import Record
from obs_ros.core.typing import Array, BoolArray
from obs_ros.inference.objective import Objective
from obs_ros.inference.prior import Posterior, Prior


@dataclass(frozen=True)
class Outlier:
    """A sample left out: its time (s), its output's place, and its size in deviations of noise.

    `burst` is the time (s) of the first sample of the burst that it belongs to; None: to none.
    """

    time: float
    output: int
    size: float
    burst: float | None = None


@dataclass(frozen=True, eq=False)
class WindowState:
    """A posed window: its record, its objective and the prior of its unknowns.

    `noise_known`: the objective's scales are the outputs' noise, given or learned; otherwise they
    are guesses. `correlation`: the noise's at lag 1, which the scales make up for. `outliers` are
    samples that were left out: in record and objective they are not measured. Without `robust`
    none is. `exact`: integration errs far less than the noise all over the box. `told_by`: so many
    windows, about as long, told the noise; infinite where it is given.
    """

    record: Record
    objective: Objective
    prior: Prior
    noise_known: bool
    correlation: float = 0.0
    outliers: tuple[Outlier, ...] = ()
    robust: bool = True
    exact: bool = False
    told_by: float = np.inf

    @property
    def start(self) -> float:
        """Time (s) of the first sample."""
        return float(self.record.t[0])

    @property
    def duration(self) -> float:
        """Time (s) from the first sample to the last."""
        return float(self.record.t[-1] - self.record.t[0])

    @property
    def noise_given(self) -> bool:
        """Whether the outputs' noise was given, not learned."""
        return self.noise_known and bool(np.isinf(self.told_by))

    @property
    def posterior(self) -> Posterior:
        """The squares of residuals and prior, which a fit minimises."""
        return Posterior(self.objective, self.prior)

    @property
    def with_given_priors(self) -> Objective | Posterior:
        """The squares of residuals and given priors alone, which a window by itself minimises."""
        if self.prior.given is None or not self.objective.is_least_squares:
            return self.objective
        return Posterior(self.objective, self.prior.without_boxes)

    def rescaled(self, factors: Array) -> 'WindowState':
        """Return the window with the outputs' scales (r,) multiplied by `factors` (r,)."""
        return replace(self, objective=self.objective.rescaled(factors))

    def without(self, samples: BoolArray) -> 'WindowState':
        """Return the window with some samples (K, r) taken as not measured."""
        record = self.record.with_outputs(np.where(samples, np.nan, self.record.y))
        objective = replace(self.objective, grid=self.objective.grid.without(samples))
        return replace(self, record=record, objective=objective)


def criterion_of(window: WindowState, cost: float) -> float:
    """Return the criterion of a window at a cost, squares and penalties in units of its scales."""
    weight = window.objective.grid.weight
    return cost - 2.0 * float(np.sum(np.log(weight, where=weight > 0.0, out=np.zeros_like(weight))))
