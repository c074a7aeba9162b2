"""Children of a roulette wheel, bred until they are inside: Porter & Passino 1995, section 2.

Two parents whom the wheel chooses exchange the tails of their strings, and genes mutate; a child
out of its domain is bred again. Loops and arrays take the same draws and give the same genes.
"""

import numpy as np

from obs_ros.core.jit import accelerated
from obs_ros.core.typing import Array, BoolArray, IntArray
from obs_ros.optimization.decimal_coding import Base10, Genes, digits_of, whole_numbers
from obs_ros.optimization.genetic_operators import chosen_by, mutated, string_crossover, wheel_of


def bred_until_inside(
    coding: Base10,
    genes: Genes,
    fitness: Array,
    children: int,
    crossover: float,
    mutation: float,
    tries: int,
    rng: np.random.Generator,
) -> Genes:
    """Return children (C, T, G) of genes (N, T, G), chosen by their fitness (N,).

    Each is bred again, up to `tries` times, until all its traits are inside; then the traits of all
    are clamped. Strings are crossed with probability `crossover`, genes mutate with `mutation`.
    """
    _, traits, count = genes.shape
    wheel = wheel_of(fitness)
    bred = np.empty((children, traits, count), dtype=np.int8)
    outside = np.arange(children)
    for attempt in range(tries + 1):
        pairs = (outside.size + 1) // 2
        draws = rng.random(4 * pairs + outside.size * traits * count)
        outside = _bred(
            genes, wheel, crossover, mutation, coding.lowest, coding.highest, coding.signed, draws,
            outside, bred, attempt == tries,
        )  # fmt: skip
        if not outside.size:
            break
    return bred


def _bred_on_arrays(
    genes: Genes, wheel: Array, crossover: float, mutation: float, lowest: IntArray,
    highest: IntArray, signed: BoolArray, draws: Array, outside: IntArray, children: Genes,
    last: bool,
) -> IntArray:  # fmt: skip
    """Breed those children (C, T, G) anew that are `outside` (M,); return which still are.

    At the `last` attempt traits of all children are clamped, and none is outside.
    """
    again = outside.size
    pairs = (again + 1) // 2
    parents, crosses, sites, alleles = np.split(draws, [2 * pairs, 3 * pairs, 4 * pairs])
    a, b = genes[chosen_by(wheel, parents.reshape(pairs, 2))].swapaxes(0, 1)
    bred = string_crossover(a, b, crossover, crosses, sites)[:again]
    children[outside] = mutated(bred, signed, mutation, alleles.reshape(bred.shape))
    whole = whole_numbers(children)
    if last:
        children[:] = digits_of(np.clip(whole, lowest, highest), genes.shape[2] - 1)
        return np.empty(0, dtype=np.int64)
    return np.flatnonzero(((whole < lowest) | (whole > highest)).any(axis=1))


def _bred_in_loops(
    genes: Genes, wheel: Array, crossover: float, mutation: float, lowest: IntArray,
    highest: IntArray, signed: BoolArray, draws: Array, outside: IntArray, children: Genes,
    last: bool,
) -> IntArray:  # fmt: skip
    """The same gene by gene, which takes a twentieth of the time where it is compiled."""
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
        place = 4 * pairs + k * length
        for i in range(traits):
            for j in range(count):
                draw = draws[place + i * count + j]
                row = head if i * count + j < site else tail
                gene = genes[min(row, size - 1), i, j]
                if draw < mutation and j > 0:
                    gene = np.int8(min(draw * width, 9.0))
                elif draw < mutation and signed[i]:
                    gene = np.int8(1 - gene)
                children[child, i, j] = gene
    left = 0
    still = np.empty(len(children), dtype=np.int64)
    for child in range(len(children)):
        inside = True
        for i in range(traits):
            whole = np.int64(0)
            for j in range(1, count):
                whole = 10 * whole + children[child, i, j]
            whole = -whole if children[child, i, 0] == 1 else whole
            inside = inside and lowest[i] <= whole <= highest[i]
            if last:
                whole = min(max(whole, lowest[i]), highest[i])
                children[child, i, 0] = 1 if whole < 0 else 0
                rest = abs(whole)
                for j in range(count - 1, 0, -1):
                    children[child, i, j] = rest % 10
                    rest //= 10
        if not (last or inside):
            still[left] = child
            left += 1
    return still[:left]


_bred = accelerated(_bred_in_loops, _bred_on_arrays)
