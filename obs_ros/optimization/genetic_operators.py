"""Selection, crossover, mutation and elitism on chromosomes of decimal digits.

Porter & Passino 1995 select by roulette wheel and cross whole strings at one site; Gremling &
Passino 2000 take parents from the best D, cross every trait and put a random value where a trait
leaves its range. All work on a population at once, and every random number comes in as a draw,
uniform on [0, 1): the same draws give the same genes.
"""

import math
from typing import NamedTuple

import numpy as np

from obs_ros.core.jit import accelerated
from obs_ros.core.typing import AnyArray, Array, BoolArray, IntArray
from obs_ros.optimization.decimal_coding import Base10, Genes, digits_of, whole_numbers

UNIT = 2.0**-32  # a draw of 32 bits times this is one of [0, 1)
LEAST = float(np.finfo(np.float64).tiny)
MANTISSA = np.uint64(11)  # bits of 64 that a float has no room for


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


class Draws(NamedTuple):
    """The random numbers of a generation: P pairs, C children, T traits, G genes.

    Whole numbers of 32 bits, of which a gene needs no more, and of 64 bits where a value is drawn.
    """

    parents: AnyArray  # (P, 2)
    sites: AnyArray  # (P, T)
    alleles: AnyArray  # (C, T, G)
    fresh: AnyArray  # (C, T)

    @classmethod
    def of(cls, children: int, traits: int, genes: int, rng: np.random.Generator) -> 'Draws':
        """Draw for so many children, all at once: that takes half of the time."""
        pairs = (children + 1) // 2
        shapes = (pairs, 2), (pairs, traits), (children, traits, genes)
        sizes = [math.prod(shape) for shape in shapes]
        starts = [children * traits]
        for size in sizes:
            starts.append(starts[-1] + (size + 1) // 2)
        raw = rng.bit_generator.random_raw(starts[-1])
        parents, sites, alleles = (
            raw[start:].view(np.uint32)[:size].reshape(shape)
            for start, size, shape in zip(starts, sizes, shapes, strict=False)
        )
        return cls(parents, sites, alleles, raw[: starts[0]].reshape(children, traits))


def offspring(
    genes: Genes,
    order: IntArray,
    best: int,
    elite: int,
    probability: float,
    coding: Base10,
    rng: np.random.Generator,
) -> tuple[Genes, Array]:
    """Return the next generation (N, T, G) of Gremling & Passino, and its values (N, T).

    The first `elite` of order (N,), best first, survive as they are and come first. Of the others,
    two at a time have two parents among the best D, crossed in every trait and mutated; a trait out
    of range becomes a random value inside.
    """
    size, traits, count = genes.shape
    c, draws = coding, Draws.of(size - elite, traits, count, rng)
    return _offspring(genes, order, best, elite, probability, c.lowest, c.highest, c.signed,
                      c.lower, c.upper, c.scale, *draws)  # fmt: skip


def _site(genes: int, first_gene: IntArray, sites: Array) -> IntArray:
    return np.asarray(first_gene + 1 + (sites * (genes - 1 - first_gene)).astype(np.int64))


def _offspring_on_arrays(
    genes: Genes, order: IntArray, best: int, elite: int, probability: float, lowest: IntArray,
    highest: IntArray, signed: BoolArray, lower: Array, upper: Array, scale: Array,
    parents: AnyArray, sites: AnyArray, alleles: AnyArray, fresh: AnyArray,
) -> tuple[Genes, Array]:  # fmt: skip
    """One operator after the other, on the whole population."""
    first_gene = np.where(signed, 0, 1)
    pairs = among_best(order, best, parents * UNIT)
    children = trait_crossover(genes[pairs[:, 0]], genes[pairs[:, 1]], first_gene, sites * UNIT)
    children = mutated(children[: len(alleles)], signed, probability, alleles * UNIT)
    whole = whole_numbers(children)
    unit = (fresh >> MANTISSA) * 2.0**-53
    random = lowest + (unit * (highest - lowest + 1)).astype(np.int64)
    inside = (whole >= lowest) & (whole <= highest)
    whole = np.where(inside, whole, random)
    # Those inside keep their genes: a zero may have a minus sign, which the next mutation shows.
    children = np.where(inside[:, :, None], children, digits_of(whole, genes.shape[2] - 1))
    survivors = genes[order[:elite]]
    numbers = np.concatenate([whole_numbers(survivors), whole])
    return (
        np.concatenate([survivors, children]),
        np.minimum(np.maximum(numbers / scale, lower), upper),
    )


def _offspring_in_loops(
    genes: Genes, order: IntArray, best: int, elite: int, probability: float, lowest: IntArray,
    highest: IntArray, signed: BoolArray, lower: Array, upper: Array, scale: Array,
    parents: AnyArray, sites: AnyArray, alleles: AnyArray, fresh: AnyArray,
) -> tuple[Genes, Array]:  # fmt: skip
    """The same gene by gene, which takes a tenth of the time where it is compiled."""
    # Arrays one by one: Numba takes longer to look at tuples of them.
    size, traits, count = genes.shape
    pairs = len(parents)
    width, below = UNIT * 10.0 / probability, probability / UNIT
    new = np.empty(genes.shape, dtype=np.int8)
    values = np.empty((size, traits))
    for n in range(elite):
        new[n] = genes[order[n]]
    for child in range(size - elite):
        n, pair, second = elite + child, child % pairs, child // pairs
        head = order[int(parents[pair, second] * UNIT * best)]
        tail = order[int(parents[pair, 1 - second] * UNIT * best)]
        for i in range(traits):
            first = 0 if signed[i] else 1
            site = first + 1 + int(sites[pair, i] * UNIT * (count - 1 - first))
            for j in range(count):
                # Both are computed, then one is taken: whether a gene mutates cannot be foretold.
                draw = float(alleles[child, i, j])
                inherited = genes[head, i, j] if j < site else genes[tail, i, j]
                allele = np.int8(min(draw * width, 9.0))
                new[n, i, j] = allele if draw < below else inherited
            toggled = signed[i] and alleles[child, i, 0] < below
            new[n, i, 0] = 1 - genes[head, i, 0] if toggled else genes[head, i, 0]
    for n in range(size):
        for i in range(traits):
            whole = np.int64(0)
            for j in range(1, count):
                whole = 10 * whole + new[n, i, j]
            whole = -whole if new[n, i, 0] == 1 else whole
            if whole < lowest[i] or whole > highest[i]:
                unit = (fresh[n - elite, i] >> MANTISSA) * 2.0**-53
                whole = lowest[i] + np.int64(unit * (highest[i] - lowest[i] + 1))
                new[n, i, 0] = 1 if whole < 0 else 0
                rest = abs(whole)
                for j in range(count - 1, 0, -1):
                    new[n, i, j] = rest % 10
                    rest //= 10
            values[n, i] = min(max(whole / scale[i], lower[i]), upper[i])
    return new, values


_offspring = accelerated(_offspring_in_loops, _offspring_on_arrays)
