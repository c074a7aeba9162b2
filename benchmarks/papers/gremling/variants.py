"""The genetic estimator in base 2, which the paper says could be used as easily (section 2).

Named to the runner as `benchmarks.papers.gremling.variants:BinaryEstimator`.
"""

import math
from typing import Any

import numpy as np

from benchmarks.papers.base_2 import Base2
from obs_ros.core.typing import IntArray
from obs_ros.observers.papers.gase import GeneticAdaptiveStateEstimator
from obs_ros.optimization.genetic_operators import among_best, trait_crossover


class BinaryEstimator(GeneticAdaptiveStateEstimator):
    """The estimator with strings of bits, at least as fine as the digits are.

    The same operators with the same probabilities; a bit that mutates becomes any of 0 and 1, as a
    digit becomes any of 0 to 9.
    """

    def __init__(self, model: Any, **arguments: Any) -> None:
        super().__init__(model, **arguments)
        ten = self._coding
        bits = math.ceil(math.log2(int((ten.highest - ten.lowest).max()) + 1))
        self._coding: Any = Base2(ten.lower, ten.upper, bits)

    def _breed(self, order: IntArray) -> None:
        s, draw, genes = self.settings, self.rng.random, self._genes
        children, traits = len(genes) - s.elite, genes.shape[1]
        pairs = (children + 1) // 2
        parents = among_best(order, s.parents, draw((pairs, 2)))
        a, b = genes[parents[:, 0]], genes[parents[:, 1]]
        born = trait_crossover(a, b, np.zeros(traits, dtype=np.int64), draw((pairs, traits)))
        born = born[:children]
        mutate = draw(born.shape)
        # Below half of p_m a bit becomes 0, from there to p_m it becomes 1.
        allele = (mutate >= 0.5 * s.mutation).astype(np.int8)
        born = np.where(mutate < s.mutation, allele, born)
        self._genes = np.concatenate([genes[order[: s.elite]], born])
        self._values = self._coding.decode(self._genes)
        self._generation += 1
