"""Generations of a roulette wheel, bred until they are inside: Porter & Passino 1995, section 2.

The best string leaves copies. For the other places two parents whom the wheel chooses exchange the
tails of their strings, and genes mutate; a child out of its domain is bred again. Loops and arrays
take the same draws and give the same genes.
"""

import numpy as np

from obs_ros.core.jit import accelerated
from obs_ros.core.typing import Array, BoolArray, IntArray
from obs_ros.optimization.decimal_coding import (
    Base10,
    Genes,
    digits_of,
    whole_number,
    whole_numbers,
    write_digits,
)
from obs_ros.optimization.genetic_operators import (
    chosen_by,
    copies_of_best,
    mutated,
    string_crossover,
    wheel_of,
)


def next_generation(
    coding: Base10,
    genes: Genes,
    fitness: Array,
    best: int,
    crossover: float,
    mutation: float,
    tries: int,
    rng: np.random.Generator,
) -> tuple[Genes, Array]:
    """Return the next generation (N, T, G) of genes with fitness (N,), and its values (N, T).

    Copies of the `best` one come first. Each child is bred again, up to `tries` times, until all
    its traits are inside; then the traits of all children are clamped. Strings are crossed with
    probability `crossover`, genes mutate with `mutation`.
    """
    size, traits, count = genes.shape
    copies, wheel = copies_of_best(fitness), wheel_of(fitness)
    new, values = np.empty_like(genes), np.empty((size, traits))
    new[:copies] = genes[best]
    outside = np.arange(copies, size)
    for attempt in range(tries + 1):
        pairs = (outside.size + 1) // 2
        draws = rng.random(4 * pairs + outside.size * traits * count)
        outside = _bred(
            genes, wheel, crossover, mutation, coding.lowest, coding.highest, coding.signed,
            coding.lower, coding.upper, coding.scale, draws, copies, outside, attempt == tries, new,
            values,
        )  # fmt: skip
        if not outside.size:
            break
    return new, values


def _bred_on_arrays(
    genes: Genes, wheel: Array, crossover: float, mutation: float, lowest: IntArray,
    highest: IntArray, signed: BoolArray, lower: Array, upper: Array, scale: Array, draws: Array,
    copies: int, outside: IntArray, last: bool, new: Genes, values: Array,
) -> IntArray:  # fmt: skip
    """Breed those of the `new` (N, T, G) that are `outside` (M,), and return which still are.

    At the `last` attempt traits of all children are clamped, and none is outside. The first
    `copies` are no children. Writes the values (N, T), too.
    """
    again = outside.size
    pairs = (again + 1) // 2
    parents, crosses, sites, alleles = np.split(draws, [2 * pairs, 3 * pairs, 4 * pairs])
    a, b = genes[chosen_by(wheel, parents.reshape(pairs, 2))].swapaxes(0, 1)
    bred = string_crossover(a, b, crossover, crosses, sites)[:again]
    new[outside] = mutated(bred, signed, mutation, alleles.reshape(bred.shape))
    whole = whole_numbers(new)
    if last:
        whole = np.clip(whole, lowest, highest)
        new[copies:] = digits_of(whole[copies:], genes.shape[2] - 1)
    values[:] = np.minimum(np.maximum(whole / scale, lower), upper)
    return np.flatnonzero(((whole < lowest) | (whole > highest)).any(axis=1))


def _bred_in_loops(
    genes: Genes, wheel: Array, crossover: float, mutation: float, lowest: IntArray,
    highest: IntArray, signed: BoolArray, lower: Array, upper: Array, scale: Array, draws: Array,
    copies: int, outside: IntArray, last: bool, new: Genes, values: Array,
) -> IntArray:  # fmt: skip
    """The same gene by gene, which takes a twentieth of the time where it is compiled."""
    # Arrays one by one: Numba takes longer to look at tuples of them.
    size, traits, count = genes.shape
    again, length = len(outside), traits * count
    pairs, width = (again + 1) // 2, 10.0 / mutation
    for k in range(again):
        pair, second, child = k % pairs, k // pairs, outside[k]
        head = np.searchsorted(wheel, draws[2 * pair + second] * wheel[-1], side='right')
        tail = np.searchsorted(wheel, draws[2 * pair + 1 - second] * wheel[-1], side='right')
        site = 1 + int(draws[3 * pairs + pair] * (length - 1))
        if not draws[2 * pairs + pair] < crossover:
            site = length
        first = 4 * pairs + k * length
        for i in range(traits):
            for j in range(count):
                place = i * count + j
                draw = draws[first + place]
                gene = genes[min(head if place < site else tail, size - 1), i, j]
                if draw < mutation and j > 0:
                    gene = np.int8(min(draw * width, 9.0))
                elif draw < mutation and signed[i]:
                    gene = np.int8(1 - gene)
                new[child, i, j] = gene
    left = 0
    still = np.empty(size, dtype=np.int64)
    for n in range(size):
        inside = True
        for i in range(traits):
            whole = whole_number(new[n, i])
            if last and n >= copies:
                whole = min(max(whole, lowest[i]), highest[i])
                write_digits(whole, new[n, i])
            inside = inside and lowest[i] <= whole <= highest[i]
            values[n, i] = min(max(whole / scale[i], lower[i]), upper[i])
        if not inside:
            still[left] = n
            left += 1
    return still[:left]


_bred = accelerated(_bred_in_loops, _bred_on_arrays)
