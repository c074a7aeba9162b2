"""Variants of the genetic adaptive observer of which the paper tells: base 2, and one gain fixed.

Named to the runner as `benchmarks.papers.porter.variants:CLASS`.
"""

import dataclasses
from typing import Any, ClassVar

import numpy as np

from benchmarks.papers.base_2 import Base2
from obs_ros.core.typing import Array
from obs_ros.observers.papers.gao import GeneticAdaptiveObserver
from obs_ros.optimization.genetic_operators import copies_of_best, roulette, string_crossover

BITS = 24  # for a gain: 19.8 / 2^24 is about the last of six decimals


class BinaryObserver(GeneticAdaptiveObserver):
    """The observer with a base-2 genetic algorithm: same operators, a mutated bit is toggled."""

    def __init__(self, model: Any, **arguments: Any) -> None:
        super().__init__(model, **arguments)
        self._coding: Any = Base2(self._coding.lower, self._coding.upper, BITS)

    def _breed(self, fitness: Array, best: int) -> None:
        s, draw = self.settings, self.rng.random
        copies = copies_of_best(fitness)
        children = len(fitness) - copies
        pairs = (children + 1) // 2
        parents = roulette(fitness, draw((pairs, 2)))
        a, b = self._genes[parents[:, 0]], self._genes[parents[:, 1]]
        genes = string_crossover(a, b, s.crossover, draw(pairs), draw(pairs))[:children]
        genes = genes ^ (draw(genes.shape) < s.mutation)
        elite = np.repeat(self._genes[best : best + 1], copies, axis=0)
        self._genes = np.concatenate([elite, genes])
        self._values = self._coding.decode(self._genes)


class OneGainFixed(GeneticAdaptiveObserver):
    """The observer that fixes gain `fixed_gain` alone once the tolerance of eq. 11 is met.

    The genetic algorithm goes on to choose the others (section 4.2, last paragraph). The figure
    `frozen` is 1 from then on.
    """

    fixed_gain: ClassVar[int]

    def __init__(self, model: Any, **arguments: Any) -> None:
        super().__init__(model, **arguments)
        self._free = self._coding

    def _start(self, now: Any) -> None:
        self._coding, self._pinned = self._free, False
        super()._start(now)

    def _try_mean(self, now: Any, h: float, predicted: Array, error: float, cost: float) -> None:
        if self._pinned:
            return
        best = self._gains.copy()
        super()._try_mean(now, h, predicted, error, cost)
        if self._frozen:
            best[self.fixed_gain] = fixed = self._gains[self.fixed_gain]
            # Values are clamped to the range of a coding; of one point, they are that point. The
            # genes keep their own range, and go on as before.
            lower, upper = self._free.lower.copy(), self._free.upper.copy()
            lower[self.fixed_gain] = upper[self.fixed_gain] = fixed
            self._coding = dataclasses.replace(self._free, lower=lower, upper=upper)
            self._gains, self._frozen, self._pinned = best, False, True

    def _tell(self, fitness: float) -> None:
        super()._tell(fitness)
        self.figures['frozen'] = float(self._pinned)


class FirstGainFixed(OneGainFixed):
    """L1 is fixed, L2 goes on."""

    fixed_gain = 0


class SecondGainFixed(OneGainFixed):
    """L2 is fixed, L1 goes on."""

    fixed_gain = 1
