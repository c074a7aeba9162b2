"""Selection, crossover, mutation and elitism on chromosomes of decimal digits.

Porter & Passino 1995 select by roulette wheel and cross whole strings at one site; Gremling &
Passino 2000 take parents from the best D and cross every trait. All work on a population at once,
and every random number comes in as a draw, uniform on [0, 1): the same draws give the same genes.
`roulette_breeding` and `trait_breeding` make generations of them.
"""

import numpy as np

from obs_ros.core.typing import Array, BoolArray, IntArray
from obs_ros.optimization.decimal_coding import Genes

LEAST = float(np.finfo(np.float64).tiny)


def fitness_of(costs: Array) -> Array:
    """Map costs J (N,) to fitnesses 1 / |J|, twice the largest where J = 0 (Porter eq. 7).

    A candidate that costs infinity has fitness 0.
    """
    costs = np.abs(costs)
    nothing = costs == 0.0
    fitness = 1.0 / np.where(nothing, np.inf, costs)
    largest = fitness.max()
    return np.where(nothing, 2.0 * largest if largest > 0.0 else 1.0, fitness)


def wheel_of(fitness: Array) -> Array:
    """Return the rising ends (N,) of the candidates' shares of a roulette wheel.

    With no fitness at all, every candidate has the same share.
    """
    wheel: Array = (fitness / max(fitness.max(), LEAST)).cumsum()
    if not (np.isfinite(wheel[-1]) and wheel[-1] > 0.0):
        wheel = np.arange(1.0, fitness.size + 1.0)
    return wheel


def chosen_by(wheel: Array, draws: Array) -> IntArray:
    """Choose candidates (as draws' shape) by a wheel (N,), each as likely as its share is wide."""
    chosen = np.searchsorted(wheel, draws * wheel[-1], side='right')
    return np.asarray(np.minimum(chosen, wheel.size - 1))


def roulette(fitness: Array, draws: Array) -> IntArray:
    """Choose candidates (as draws' shape), each with a probability in proportion to its fitness."""
    return chosen_by(wheel_of(fitness), draws)


def among_best(order: IntArray, best: int, draws: Array) -> IntArray:
    """Choose candidates (as draws' shape) from the first `best` of order (N,), all as likely."""
    return np.asarray(order[(draws * best).astype(np.int64)])


def copies_of_best(fitness: Array) -> int:
    """Return round(F_best / mean F) copies that the best one leaves, 1 to N (Porter, section 2)."""
    mean = float(fitness.sum()) / fitness.size
    return min(max(round(float(fitness.max()) / mean) if mean > 0.0 else 1, 1), fitness.size)


def string_crossover(a: Genes, b: Genes, probability: float, crosses: Array, sites: Array) -> Genes:
    """Exchange the tails of two strings (P, T, G), behind one site, with some probability.

    crosses and sites (P,) are draws; the site is one of 1 to T G - 1. Returns the 2 P children: the
    heads of `a`, then the heads of `b`.
    """
    traits, genes = a.shape[1:]
    site = 1 + (sites * (traits * genes - 1)).astype(np.int64)
    tail = np.arange(traits * genes).reshape(traits, genes) >= site[:, None, None]
    swap = tail & (crosses < probability)[:, None, None]
    return np.concatenate([np.where(swap, b, a), np.where(swap, a, b)])


def trait_crossover(a: Genes, b: Genes, first_gene: IntArray, sites: Array) -> Genes:
    """Exchange the tails of every trait of two strings (P, T, G), behind a site in each.

    sites (P, T) are draws; a trait's site is one between two genes that take part, or its end where
    it has but one. Returns the 2 P children: the heads of `a`, then the heads of `b`.
    """
    swap = np.arange(a.shape[2]) >= _site(a.shape[2], first_gene, sites)[:, :, None]
    return np.concatenate([np.where(swap, b, a), np.where(swap, a, b)])


def mutated(genes: Genes, signed: BoolArray, probability: float, draws: Array) -> Genes:
    """Change every gene with some probability: a digit to any of 0 to 9, a sign to the other.

    draws (N, T, G): below `probability` the gene mutates, and where below chooses its new value.
    """
    changed = draws < probability
    alleles = np.minimum(draws * (10.0 / probability), 9.0).astype(np.int8)
    children = np.where(changed, alleles, genes)
    toggled = changed[:, :, 0] & signed
    children[:, :, 0] = np.where(toggled, 1 - genes[:, :, 0], genes[:, :, 0])
    return children


def _site(genes: int, first_gene: IntArray, sites: Array) -> IntArray:
    return np.asarray(first_gene + 1 + (sites * (genes - 1 - first_gene)).astype(np.int64))
