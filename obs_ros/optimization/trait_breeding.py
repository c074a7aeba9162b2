"""Generations crossed in every trait, and mended where a trait is out of range.

Gremling & Passino 2000, section 2: the elite survives, two parents among the best D exchange the
tails of all their traits, and genes mutate; a trait out of its range becomes a random value inside.
Loops and arrays take the same draws and give the same genes.
"""

import math
from typing import NamedTuple

import numpy as np

from obs_ros.core.jit import accelerated
from obs_ros.core.typing import AnyArray, Array, BoolArray, IntArray
from obs_ros.optimization.decimal_coding import (
    Base10,
    Genes,
    digits_of,
    whole_number,
    whole_numbers,
    write_digits,
)
from obs_ros.optimization.genetic_operators import among_best, mutated, trait_crossover

UNIT = 2.0**-32  # a draw of 32 bits times this is one of [0, 1)
MANTISSA = np.uint64(11)  # bits of 64 that a float has no room for


class Draws(NamedTuple):
    """The random numbers of a generation: P pairs, C children, T traits, G genes.

    Whole numbers of 32 bits, of which a gene needs no more, and of 64 bits where a value is drawn.
    They lie one behind the other in words of 64 bits; each array begins with a word.
    """

    fresh: AnyArray  # (C, T)
    parents: AnyArray  # (P, 2)
    sites: AnyArray  # (P, T)
    alleles: AnyArray  # (C, T, G)

    @classmethod
    def of(cls, words: AnyArray, children: int, traits: int, genes: int) -> 'Draws':
        """Return the parts of so many words (W,)."""
        pairs = (children + 1) // 2
        shapes = (pairs, 2), (pairs, traits), (children, traits, genes)
        start, parts = children * traits, []
        for shape in shapes:
            size = math.prod(shape)
            end = start + (size + 1) // 2
            parts.append(words[start:end].view(np.uint32)[:size].reshape(shape))
            start = end
        return cls(words[: children * traits].reshape(children, traits), *parts)

    @staticmethod
    def words(children: int, traits: int, genes: int) -> int:
        """Return the number of words that so many children need."""
        pairs, values = (children + 1) // 2, children * traits
        return values + pairs + (pairs * traits + 1) // 2 + (values * genes + 1) // 2


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
    words = rng.bit_generator.random_raw(Draws.words(size - elite, traits, count))
    return _offspring(
        genes, order, best, elite, probability, coding.lowest, coding.highest, coding.signed,
        coding.lower, coding.upper, coding.scale, words,
    )  # fmt: skip


def _offspring_on_arrays(
    genes: Genes, order: IntArray, best: int, elite: int, probability: float, lowest: IntArray,
    highest: IntArray, signed: BoolArray, lower: Array, upper: Array, scale: Array, words: AnyArray,
) -> tuple[Genes, Array]:  # fmt: skip
    """One operator after the other, on the whole population."""
    size, traits, count = genes.shape
    fresh, parents, sites, alleles = Draws.of(words, size - elite, traits, count)
    first_gene = np.where(signed, 0, 1)
    pairs = among_best(order, best, parents * UNIT)
    children = trait_crossover(genes[pairs[:, 0]], genes[pairs[:, 1]], first_gene, sites * UNIT)
    children = mutated(children[: size - elite], signed, probability, alleles * UNIT)
    whole = whole_numbers(children)
    unit = (fresh >> MANTISSA) * 2.0**-53
    random = lowest + (unit * (highest - lowest + 1)).astype(np.int64)
    inside = (whole >= lowest) & (whole <= highest)
    whole = np.where(inside, whole, random)
    # Those inside keep their genes: a zero may have a minus sign, which the next mutation shows.
    children = np.where(inside[:, :, None], children, digits_of(whole, count - 1))
    survivors = genes[order[:elite]]
    numbers = np.concatenate([whole_numbers(survivors), whole])
    return (
        np.concatenate([survivors, children]),
        np.minimum(np.maximum(numbers / scale, lower), upper),
    )


def _offspring_in_loops(
    genes: Genes, order: IntArray, best: int, elite: int, probability: float, lowest: IntArray,
    highest: IntArray, signed: BoolArray, lower: Array, upper: Array, scale: Array, words: AnyArray,
) -> tuple[Genes, Array]:  # fmt: skip
    """The same gene by gene, which takes a tenth of the time where it is compiled."""
    # Arrays one by one: Numba takes longer to look at tuples of them.
    size, traits, count = genes.shape
    children = size - elite
    pairs, length = (children + 1) // 2, traits * count
    new, halves = np.empty(genes.shape, dtype=np.int8), words.view(np.uint32)
    parents = 2 * children * traits
    sites = parents + 2 * pairs
    alleles = sites + 2 * ((pairs * traits + 1) // 2)
    for n in range(elite):
        new[n] = genes[order[n]]
    for pair in range(pairs - 1, -1, -1):
        one = order[int(halves[parents + 2 * pair] * UNIT * best)]
        other = order[int(halves[parents + 2 * pair + 1] * UNIT * best)]
        # With an odd number of children the last pair has one: what its twin overwrites comes next.
        twin = min(elite + pair + pairs, size - 1)
        for i in range(traits):
            first = 0 if signed[i] else 1
            site = first + 1 + int(halves[sites + pair * traits + i] * UNIT * (count - 1 - first))
            for j in range(count):
                a, b = genes[one, i, j], genes[other, i, j]
                swap = (a ^ b) & -np.int8(j >= site)  # no branch: no processor foretells sites
                new[twin, i, j] = b ^ swap
                new[elite + pair, i, j] = a ^ swap
    draws = halves[alleles : alleles + children * length]
    _mutate(new[elite:].reshape(children * length), draws, probability, signed, count)
    return new, _mended(new, elite, lowest, highest, lower, upper, scale, words)


@accelerated
def _mutate(
    genes: Genes, draws: AnyArray, probability: float, signed: BoolArray, count: int
) -> None:
    """Change genes (C T G,) of traits of `count` genes each by draws of 32 bits (C T G,)."""
    signs = genes[::count].copy()
    width, below = UNIT * 10.0 / probability, np.int64(np.ceil(probability / UNIT))
    # Unsigned and without branches, so that it is vectorised: all genes have an allele drawn.
    for k in range(np.uint64(genes.size)):
        allele, gene = np.int8(np.int32(min(float(draws[k]) * width, 9.0))), genes[k]
        genes[k] = allele if np.int64(draws[k]) < below else gene
    for first in range(0, signs.size, signed.size):
        for i in range(signed.size):
            place = (first + i) * count
            toggled = signed[i] and np.int64(draws[place]) < below
            genes[place] = 1 - signs[first + i] if toggled else signs[first + i]


@accelerated
def _mended(
    new: Genes, elite: int, lowest: IntArray, highest: IntArray, lower: Array, upper: Array,
    scale: Array, words: AnyArray,
) -> Array:  # fmt: skip
    """Replace traits (N, T, G) out of range by values drawn from the words; return all values."""
    size, traits, _ = new.shape
    values = np.empty((size, traits))
    outside, left = np.empty((size * traits, 2), dtype=np.int64), 0
    # First who is outside, which no processor can foretell: one branch each would cost far more.
    for n in range(size):
        for i in range(traits):
            whole = whole_number(new[n, i])
            values[n, i] = min(max(whole / scale[i], lower[i]), upper[i])
            outside[left, 0], outside[left, 1] = n, i
            left += (whole < lowest[i]) | (whole > highest[i])
    for k in range(left):
        n, i = outside[k]
        unit = (words[(n - elite) * traits + i] >> MANTISSA) * 2.0**-53
        whole = lowest[i] + np.int64(unit * (highest[i] - lowest[i] + 1))
        values[n, i] = min(max(whole / scale[i], lower[i]), upper[i])
        write_digits(whole, new[n, i])
    return values


_offspring = accelerated(_offspring_in_loops, _offspring_on_arrays)
