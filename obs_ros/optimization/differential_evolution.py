"""Differential evolution over the unit box (Storn & Price 1997; Yang, Li & Dahhou 2020)."""

from typing import ClassVar, Literal, get_args

import numpy as np

from obs_ros.core.deadline import Deadline
from obs_ros.core.typing import Array, IntArray

Strategy = Literal['rand/1/bin', 'best/1/bin']


class DifferentialEvolution:
    """Evolves a population by ask and tell.

    `ask` returns candidates (size, d), the first time the population itself; `tell` takes their
    costs (size,). A mutant is base + weight * (difference of two others), with a random or the best
    individual as base; each component comes from it with probability `crossover`, at least one. A
    component outside the box is drawn again. A trial replaces its parent when it costs less.

    Raises ValueError for fewer than four individuals, an unknown strategy, or a weight outside
    (0, 2] or crossover outside [0, 1].
    """

    most_draws: ClassVar[int] = 2**20  # random numbers at once: 8 MB

    def __init__(
        self,
        population: Array,
        rng: np.random.Generator,
        strategy: Strategy = 'rand/1/bin',
        weight: float = 0.7,
        crossover: float = 0.7,
    ) -> None:
        check_settings(len(population), strategy, weight, crossover)
        self.population = population.copy()
        self.costs = np.full(len(population), np.inf)
        self.generation = 0
        self._rng = rng
        self._strategy = strategy
        self._weight = weight
        self._crossover = crossover
        self._trials = self.population

    @property
    def best(self) -> tuple[Array, float]:
        """Best individual (d,) so far and its cost."""
        i = int(self.costs.argmin())
        return self.population[i].copy(), float(self.costs[i])

    def ask(self, deadline: Deadline | None = None) -> Array:
        """Return the next candidates (size, d); those that the deadline leaves no time for, any."""
        if self.generation > 0:
            self._trials = self._recombine(self._mutants(deadline))
        return self._trials

    def tell(self, costs: Array) -> None:
        """Take the costs (size,) of the candidates that `ask` returned."""
        better = costs < self.costs
        self.population = np.where(better[:, None], self._trials, self.population)
        self.costs = np.where(better, costs, self.costs)
        self.generation += 1

    def _mutants(self, deadline: Deadline | None) -> Array:
        a, b, c = self._others(deadline)
        base = self.population[a]
        if self._strategy == 'best/1/bin':
            base = self.population[[self.costs.argmin()]]
        return base + self._weight * (self.population[b] - self.population[c])

    def _others(self, deadline: Deadline | None) -> tuple[IntArray, IntArray, IntArray]:
        """Draw three individuals for each, different from it and from each other."""
        size = len(self.population)
        others = np.tile(np.arange(3), (size, 1))
        # Row by row the draws are the same, and a large population needs no square of its size.
        block = max(1, self.most_draws // size)
        for first in range(0, size, block):
            if first and deadline is not None and deadline.passed:
                break
            rows = np.arange(first, min(first + block, size))
            order = self._rng.random((rows.size, size))
            order[rows - first, rows] = np.inf
            others[rows] = np.argsort(order, axis=1)[:, :3]
        a, b, c = others.T
        return a, b, c

    def _recombine(self, mutants: Array) -> Array:
        size, dimension = mutants.shape
        crossed = self._rng.random((size, dimension)) < self._crossover
        crossed[np.arange(size), self._rng.integers(dimension, size=size)] = True
        trials = np.where(crossed, mutants, self.population)
        outside = (trials < 0.0) | (trials > 1.0)
        trials[outside] = self._rng.random(np.count_nonzero(outside))
        return trials


def check_count(name: str, value: int, least: int) -> None:
    """Raise ValueError unless the value is an integer and not below the least."""
    if isinstance(value, bool) or not isinstance(value, int) or value < least:
        raise ValueError(f'{name} must be an integer >= {least}, not {value!r}')


def check_settings(size: int, strategy: str, weight: float, crossover: float) -> None:
    """Raise ValueError for settings that differential evolution cannot work with."""
    check_count('population', size, 4)
    if strategy not in get_args(Strategy):
        raise ValueError(f'strategy {strategy!r} is none of {", ".join(get_args(Strategy))}')
    if not 0.0 < weight <= 2.0:
        raise ValueError(f'differential weight {weight} is outside (0, 2]')
    if not 0.0 <= crossover <= 1.0:
        raise ValueError(f'crossover probability {crossover} is outside [0, 1]')
