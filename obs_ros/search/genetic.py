"""Selection, crossover, mutation and elitism on chromosomes of decimal digits.

Porter & Passino 1995 select by roulette wheel, cross whole strings at one site and breed again what
leaves its domain; Gremling & Passino 2000 take parents from the best D, cross every trait and put a
random value where a trait leaves its range. All work on a population at once, and every random
number comes in as a draw, uniform on [0, 1): the same draws give the same genes.
"""

from collections.abc import Callable

import numpy as np

from obs_ros.acceleration import accelerated
from obs_ros.search.base10 import Base10, Genes, digits_of, whole_numbers
from obs_ros.typing import AnyArray, Array, BoolArray, IntArray


def fitness_of(costs: Array) -> Array:
    """Map costs J (N,) to fitnesses 1 / |J|, twice the largest where J = 0 (Porter eq. 7).

    A candidate that costs infinity has fitness 0.
    """
    costs = np.abs(costs)
    nothing = costs == 0.0
    with np.errstate(divide='ignore'):
        fitness = np.where(nothing, 0.0, 1.0 / costs)
    largest = fitness.max()
    return np.where(nothing, 2.0 * largest if largest > 0.0 else 1.0, fitness)


def roulette(fitness: Array, draws: Array) -> IntArray:
    """Choose candidates (as draws' shape), each with a probability in proportion to its fitness.

    With no fitness at all, every candidate is as likely.
    """
    wheel = np.cumsum(fitness / max(fitness.max(), np.finfo(float).tiny))
    if not (np.isfinite(wheel[-1]) and wheel[-1] > 0.0):
        wheel = np.arange(1.0, fitness.size + 1.0)
    chosen = np.searchsorted(wheel, draws * wheel[-1], side='right')
    return np.asarray(np.minimum(chosen, fitness.size - 1))


def among_best(order: IntArray, best: int, draws: Array) -> IntArray:
    """Choose candidates (as draws' shape) from the first `best` of order (N,), all as likely."""
    return np.asarray(order[(draws * best).astype(np.int64)])


def copies_of_best(fitness: Array) -> int:
    """Return round(F_best / mean F) copies that the best one leaves, 1 to N (Porter, section 2)."""
    mean = fitness.mean()
    return int(np.clip(np.rint(fitness.max() / mean) if mean > 0.0 else 1, 1, fitness.size))


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


def mutated(
    genes: Genes, signed: BoolArray, probability: float | np.float32, draws: AnyArray
) -> Genes:
    """Change every gene with some probability: a digit to any of 0 to 9, a sign to the other.

    draws (N, T, G): below `probability` the gene mutates, and where below chooses its new value.
    """
    changed = draws < probability
    width = np.float32(10.0) / np.float32(probability)
    alleles = np.minimum(draws * width, np.float32(9.0)).astype(np.int8)
    children = np.where(changed, alleles, genes)
    toggled = changed[:, :, 0] & signed
    children[:, :, 0] = np.where(toggled, 1 - genes[:, :, 0], genes[:, :, 0])
    return children


def put_inside(coding: Base10, genes: Genes, draws: Array) -> Genes:
    """Return the genes with a random value, from draws (N, T), for every trait out of range."""
    whole = whole_numbers(genes)
    mended = np.where(coding.inside(whole), whole, coding.uniform(draws))
    return digits_of(mended, coding.digits)


def bred_until_inside(
    coding: Base10, breed: Callable[[int], Genes], children: int, tries: int
) -> Genes:
    """Breed each of the children again, up to `tries` times, until it is inside; clamp the others.

    `breed` returns that many new ones. A child is inside when all its traits are.
    """
    genes = breed(children)
    for _ in range(tries):
        outside = np.flatnonzero(~coding.inside(whole_numbers(genes)).all(axis=1))
        if not outside.size:
            return genes
        genes[outside] = breed(outside.size)
    whole = np.clip(whole_numbers(genes), coding.lowest, coding.highest)
    return digits_of(whole, coding.digits)


def offspring(
    genes: Genes,
    order: IntArray,
    best: int,
    elite: int,
    probability: float,
    coding: Base10,
    rng: np.random.Generator,
) -> tuple[Genes, IntArray]:
    """Return the next generation (N, T, G) of Gremling & Passino, and its whole numbers (N, T).

    The first `elite` of order (N,), best first, survive as they are and come first. Of the others,
    two at a time have two parents among the best D, crossed in every trait and mutated; a trait out
    of range becomes a random value inside.
    """
    size, traits, count = genes.shape
    children = size - elite
    pairs = (children + 1) // 2
    parents = among_best(order, best, rng.random((pairs, 2)))
    return _offspring(
        genes,
        order[:elite],
        parents,
        coding.lowest,
        coding.highest,
        coding.signed,
        # The draws are float32, and compiled or not, 0.2 must be the same number beside them.
        np.float32(probability),
        rng.random((pairs, traits)),
        rng.random((children, traits, count), dtype=np.float32),
        rng.random((children, traits)),
    )


def _site(genes: int, first_gene: IntArray, sites: Array) -> IntArray:
    return np.asarray(first_gene + 1 + (sites * (genes - 1 - first_gene)).astype(np.int64))


def _offspring_on_arrays(
    genes: Genes,
    elite: IntArray,
    parents: IntArray,
    lowest: IntArray,
    highest: IntArray,
    signed: BoolArray,
    probability: np.float32,
    sites: Array,
    alleles: AnyArray,
    fresh: Array,
) -> tuple[Genes, IntArray]:
    """One operator after the other, on the whole population."""
    first_gene = np.where(signed, 0, 1)
    children = trait_crossover(genes[parents[:, 0]], genes[parents[:, 1]], first_gene, sites)
    children = mutated(children[: len(alleles)], signed, probability, alleles)
    whole = whole_numbers(children)
    random = lowest + (fresh * (highest - lowest + 1)).astype(np.int64)
    whole = np.where((whole >= lowest) & (whole <= highest), whole, random)
    survivors = genes[elite]
    return (
        np.concatenate([survivors, digits_of(whole, genes.shape[2] - 1)]),
        np.concatenate([whole_numbers(survivors), whole]),
    )


def _offspring_in_loops(
    genes: Genes,
    elite: IntArray,
    parents: IntArray,
    lowest: IntArray,
    highest: IntArray,
    signed: BoolArray,
    probability: np.float32,
    sites: Array,
    alleles: AnyArray,
    fresh: Array,
) -> tuple[Genes, IntArray]:
    """The same gene by gene, which takes a fifth of the time where it is compiled."""
    traits, count = genes.shape[1:]
    pairs = len(parents)
    width, nine = np.float32(10.0) / np.float32(probability), np.float32(9.0)
    new = np.empty(genes.shape, dtype=np.int8)
    numbers = np.empty((len(genes), traits), dtype=np.int64)
    for n in range(len(genes)):
        child = n - elite.size
        pair = child % pairs
        for i in range(traits):
            first = 0 if signed[i] else 1
            site = count
            head = tail = elite[n] if child < 0 else 0
            if child >= 0:
                site = first + 1 + int(sites[pair, i] * (count - 1 - first))
                head = parents[pair, child // pairs]
                tail = parents[pair, 1 - child // pairs]
            sign = np.int64(genes[head, i, 0])
            if child >= 0 and signed[i] and alleles[child, i, 0] < probability:
                sign = 1 - sign
            whole = np.int64(0)
            for j in range(1, count):
                gene = np.int64(genes[head if j < site else tail, i, j])
                if child >= 0 and alleles[child, i, j] < probability:
                    gene = np.int64(min(alleles[child, i, j] * width, nine))
                new[n, i, j] = gene
                whole = 10 * whole + gene
            new[n, i, 0] = sign
            whole = -whole if sign == 1 else whole
            if whole < lowest[i] or whole > highest[i]:
                whole = lowest[i] + np.int64(fresh[child, i] * (highest[i] - lowest[i] + 1))
                new[n, i, 0] = 1 if whole < 0 else 0
                rest = abs(whole)
                for j in range(count - 1, 0, -1):
                    new[n, i, j] = rest % 10
                    rest //= 10
            numbers[n, i] = whole
    return new, numbers


_offspring = accelerated(_offspring_in_loops, _offspring_on_arrays)
