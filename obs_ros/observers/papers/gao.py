"""Genetic adaptive observer: Porter & Passino 1995.

    xhat(k) = f(xhat(k-1), u(k-1)) + L (y(k-1) - yhat(k-1)),

with f one step of forward Euler and the gains L chosen anew at every sample from a population of
strings of digits, all of which continue the same estimate; then one generation is bred.

It is here for fidelity, not because it wins: a constant gain, an EKF from a start where it is not
blind, or a UKF beat it on nearly all of its own plants. Nor is the start (0, 0) of the glycolytic
oscillator innocent: x2 = 0 stays 0 there, and to first order y does not see x2, so that an EKF
with exact derivatives never leaves it.

Some runs diverge, whether gains out of their domain are clamped (`tries` 0) or bred again first, as
the paper has it without telling its limit. The paper's freeze of the gains makes many more diverge,
and is off unless asked for. Rates: docs/papers.md.
"""

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from obs_ros.core.model import Model
from obs_ros.core.typing import Array
from obs_ros.integration.path import Path
from obs_ros.observers.output_intake import Instant
from obs_ros.observers.papers.euler import euler_step, mean_inputs, outputs_of
from obs_ros.observers.recursive import RecursiveObserver
from obs_ros.observers.settings import Settings, setting
from obs_ros.optimization.decimal_coding import Base10
from obs_ros.optimization.genetic_operators import fitness_of
from obs_ros.optimization.roulette_breeding import next_generation


@dataclass(frozen=True)
class GaoSettings(Settings):
    """The paper's constants for its linear plant (section 4.1)."""

    # Its own estimates leap from step to step: no gate could tell an outlier from that.
    innovation_gate: float = setting(
        0.0, Settings.__dataclass_fields__['innovation_gate'].metadata['description'],
        lower=0.0, upper=1e6,
    )  # fmt: skip
    population: int = setting(20, 'gains in competition, m', lower=2, upper=10_000)
    crossover: float = setting(0.6, 'probability p_c of crossover', lower=0.0, upper=1.0)
    mutation: float = setting(0.4, 'probability p_m that a digit mutates', upper=1.0, positive=True)
    digits: int = setting(7, 'digits of each gain, at least', lower=2, upper=15)
    least_gains: tuple[float, ...] = setting(
        (-9.9,), 'least gain for each state, or one for all', lower=-1e9, upper=1e9
    )
    most_gains: tuple[float, ...] = setting(
        (9.9,), 'largest gain for each state, or one for all', lower=-1e9, upper=1e9
    )
    tries: int = setting(0, 'how often gains out of range are bred again before they are clamped',
                         lower=0, upper=100)  # fmt: skip
    alpha1: float = setting(5.0, 'weight of the error now, p1', lower=0.0, upper=1e12)
    alpha2: float = setting(40.0, 'weight of the error one step ahead, p2', lower=0.0, upper=1e12)
    freeze: bool = setting(False, 'stop adapting when mean gains are as good as the best')
    averaged: int = setting(200, 'gains N_l in that mean', lower=1, upper=100_000)
    tolerance: float = setting(
        5e-6, 'gamma: how much worse the mean gains may be', lower=0.0, upper=1e12
    )


class GeneticAdaptiveObserver(RecursiveObserver):
    """States of a plant with one output and known parameters; its gains are what adapts.

    Figures: L1, L2, ..., the gains in use; `best_fitness`, -J of the best ones, where it was
    computed; `generation`; `frozen`, 1 once the mean gains are used for good.

    Raises ValueError for a model with several outputs and for ranges of gains that are crossed, not
    finite, or neither one nor as many as states.
    """

    Settings: ClassVar[type[Settings]] = GaoSettings
    estimates_parameters: ClassVar[bool] = False

    def __init__(self, model: Model | str, **arguments: Any) -> None:
        super().__init__(model, **arguments)
        n = len(self.model.states)
        for name in ('least_gains', 'most_gains'):
            if len(getattr(self.settings, name)) not in (1, n):
                raise ValueError(f'{name} must have 1 or {n} gains, one for each state')
        lower, upper = (
            np.broadcast_to(gains, n)
            for gains in (self.settings.least_gains, self.settings.most_gains)
        )
        self._coding = Base10.of(lower, upper, self.settings.digits, signed=True)
        self._names_of_gains = [f'L{i}' for i in range(1, n + 1)]

    @classmethod
    def suits(cls, model: Model) -> None:
        if len(model.outputs) != 1:
            raise ValueError(
                f'model {model.name!r} has {len(model.outputs)} outputs; '
                'the genetic adaptive observer corrects with one'
            )

    def _start(self, now: Instant) -> None:
        draws = self.rng.random((self.settings.population, self.x.size))
        self._genes = self._coding.first_population(draws)
        self._values = self._coding.decode(self._genes)
        self._gains = self._values[0]
        # The best gains of the last N_l samples, the newest last, and how many there were so far.
        self._best, self._kept = np.empty((self.settings.averaged, self.x.size)), 0
        self._generation, self._frozen = 0, False
        self.innovation[:] = now.y - outputs_of(self.model, now.t, self.x, now.u, self.p)
        self._tell(math.nan)

    def _step(self, before: Instant, now: Instant, path: Path) -> None:
        model, h = self.model, (now.stamp - before.stamp) / 1e9
        error = self.innovation.item() if math.isfinite(before.y[0]) else 0.0
        predicted = euler_step(model, before.t, h, self.x, mean_inputs(path), self.p)
        fitness = math.nan
        if math.isfinite(now.y[0]) and not self._frozen:
            fitness = self._adapt(now, h, predicted, error)
        self.x[:] = predicted + self._gains * error
        self.innovation[:] = now.y - outputs_of(model, now.t, self.x, now.u, self.p)
        self._tell(fitness)

    def _adapt(self, now: Instant, h: float, predicted: Array, error: float) -> float:
        """Choose the gains and breed the next generation; return the best's fitness -J."""
        gains = self._values
        costs = self._costs(now, h, predicted, error, gains)
        best = int(costs.argmin())
        self._gains = gains[best]
        if self.settings.freeze:
            self._try_mean(now, h, predicted, error, float(costs[best]))
        if not self._frozen:
            self._breed(fitness_of(costs), best)
            self._generation += 1
        return -float(costs[best])

    def _costs(self, now: Instant, h: float, predicted: Array, error: float, gains: Array) -> Array:
        """Return J (N,) of gains (N, n), eqs. 8-9: a1 p1^2 + a2 p2^2; +inf where not finite."""
        s, y = self.settings, now.y[0]
        x = predicted[:, None] + gains.T * error
        p1 = y - outputs_of(self.model, now.t, x, now.u, self.p)[0]
        x = euler_step(self.model, now.t, h, x, now.u, self.p) + gains.T * p1
        p2 = outputs_of(self.model, now.t + h, x, now.u, self.p)[0] - y
        costs = s.alpha1 * p1**2 + s.alpha2 * p2**2
        return np.where(np.isfinite(costs), costs, np.inf)

    def _try_mean(
        self, now: Instant, h: float, predicted: Array, error: float, cost: float
    ) -> None:
        """Take the mean of the last N_l best gains, for good, where it is good enough (eq. 11).

        Read as J_mean - J_best <= gamma: as printed, with the signs the other way, it always holds.
        """
        if self._kept >= self.settings.averaged:
            mean = self._best.mean(axis=0)
            excess = self._costs(now, h, predicted, error, mean[None])[0] - cost
            if excess <= self.settings.tolerance:
                self._gains, self._frozen = mean, True
        self._best[:-1] = self._best[1:]
        self._best[-1] = self._gains
        self._kept += 1

    def _breed(self, fitness: Array, best: int) -> None:
        """Put the next generation in its place: copies of the best, then children of the wheel."""
        s = self.settings
        self._genes, self._values = next_generation(
            self._coding, self._genes, fitness, best, s.crossover, s.mutation, s.tries, self.rng
        )

    def _tell(self, fitness: float) -> None:
        self.figures.update(zip(self._names_of_gains, self._gains.tolist(), strict=True))
        self.figures.update(generation=float(self._generation), frozen=float(self._frozen))
        self.figures.pop('best_fitness', None)
        if math.isfinite(fitness):
            self.figures['best_fitness'] = fitness
