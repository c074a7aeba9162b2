"""Tests of obs_ros.optimization.genetic_operators."""

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from obs_ros.optimization import genetic_operators
from obs_ros.optimization.decimal_coding import Base10, Genes, whole_numbers
from obs_ros.optimization.genetic_operators import (
    Draws,
    among_best,
    copies_of_best,
    fitness_of,
    mutated,
    offspring,
    roulette,
    string_crossover,
    trait_crossover,
)

CODING = Base10.of([1.8, 0.8, -0.2], [2.3, 1.2, 0.2], 5)
HALF = np.full(1, 0.5)


def two_parents() -> tuple[Genes, Genes]:
    a = np.arange(16, dtype=np.int8).reshape(1, 2, 8)
    return a, a + 50


def test_fitness_is_one_over_the_cost_and_twice_the_largest_at_none() -> None:
    assert fitness_of(np.array([2.0, 0.0, -0.5, np.inf])).tolist() == [0.5, 4.0, 2.0, 0.0]
    assert fitness_of(np.zeros(3)).tolist() == [1.0, 1.0, 1.0]


def test_the_wheel_turns_in_proportion_to_fitness() -> None:
    draws = np.random.default_rng(1).random(20000)
    share = np.bincount(roulette(np.array([1.0, 0.0, 2.0, 5.0]), draws), minlength=4) / draws.size
    np.testing.assert_allclose(share, [0.125, 0.0, 0.25, 0.625], atol=0.015)


@pytest.mark.parametrize('fitness', [np.zeros(4), np.array([1e308] * 4), np.array([5e-324] * 4)])
def test_the_wheel_stands_any_fitness(fitness: Any) -> None:
    chosen = roulette(fitness, np.linspace(0.0, 1.0, 400, endpoint=False))
    assert set(chosen.tolist()) <= {0, 1, 2, 3}
    assert np.bincount(chosen, minlength=4).max() <= 400


def test_only_the_best_are_parents_and_all_of_them() -> None:
    order = np.array([4, 2, 0, 1, 3])
    chosen = among_best(order, 3, np.random.default_rng(2).random((3000, 2)))
    share = np.bincount(chosen.ravel(), minlength=5) / 6000
    np.testing.assert_allclose(share, [1 / 3, 0.0, 1 / 3, 0.0, 1 / 3], atol=0.03)


def test_the_best_leaves_copies_as_it_beats_the_mean() -> None:
    assert copies_of_best(np.array([1.0, 1.0, 1.0, 1.0])) == 1
    assert copies_of_best(np.array([6.0, 1.0, 1.0, 0.0])) == 3
    assert copies_of_best(np.array([1.0, 0.0, 0.0, 0.0])) == 4
    assert copies_of_best(np.zeros(4)) == 1


def test_a_string_is_crossed_at_one_site_of_fifteen() -> None:
    a, b = two_parents()
    for site in range(1, 16):
        children = string_crossover(a, b, 0.6, HALF, np.array([(site - 0.5) / 15.0]))
        heads = children.reshape(2, 16)
        assert heads[0].tolist() == [*range(site), *range(50 + site, 66)]
        assert heads[1].tolist() == [*range(50, 50 + site), *range(site, 16)]
    uncrossed = string_crossover(a, b, 0.5, HALF, HALF)
    assert (uncrossed == np.concatenate([a, b])).all()


def test_every_trait_is_crossed_between_two_of_its_genes() -> None:
    a, b = two_parents()
    first_gene = np.array([0, 1])  # the second trait has no sign
    low = trait_crossover(a, b, first_gene, np.zeros((1, 2)))
    assert low[0].tolist() == [[0, *range(51, 58)], [8, 9, *range(60, 66)]]
    high = trait_crossover(a, b, first_gene, np.full((1, 2), 0.999))
    assert high[0].tolist() == [[*range(7), 57], [*range(8, 15), 65]]
    assert (low[0] + low[1] == a[0] + b[0]).all()


def test_genes_mutate_as_often_as_told_and_to_any_digit() -> None:
    genes = np.full((4000, 3, 6), 3, dtype=np.int8)
    genes[:, :, 0] = 0
    genes = mutated(genes, CODING.signed, 0.2, np.random.default_rng(3).random(genes.shape))
    digits = genes[:, :, 1:].ravel()
    share = np.bincount(digits, minlength=10) / digits.size
    np.testing.assert_allclose(share, [0.02] * 3 + [0.82] + [0.02] * 6, atol=0.005)  # 3 sd
    np.testing.assert_allclose(genes[:, :, 0].mean(axis=0), [0.0, 0.0, 0.2], atol=0.02)


def test_a_trait_out_of_range_becomes_a_random_value_and_others_stay() -> None:
    genes = np.zeros((1001, 3, 6), dtype=np.int8)
    genes[:, 0, 1] = 2  # 2.0 is inside, 0.0 is below 0.8, 0.0 is inside
    order, rng = np.arange(1001), np.random.default_rng(4)
    mended = offspring(genes, order, 2, 1, 1e-9, CODING, rng)[1][1:]
    assert (mended[:, 0] == 2.0).all() and (mended[:, 2] == 0.0).all()
    assert mended[:, 1].min() < 0.802 and mended[:, 1].max() > 1.198
    assert mended[:, 1].mean() == pytest.approx(1.0, abs=0.015)


@given(st.integers(0, 2**32), st.integers(2, 40), st.floats(0.01, 1.0), st.booleans())
@settings(max_examples=60)
def test_offspring_are_in_range_and_the_elite_survive(
    seed: int, size: int, probability: float, signed: bool
) -> None:
    rng = np.random.default_rng(seed)
    coding = Base10.of([1.8, 0.8, -0.2], [2.3, 1.2, 0.2], 5, signed=signed)
    genes = coding.first_population(rng.random((size, 3)))
    order, elite = rng.permutation(size), int(rng.integers(1, size))
    best = int(rng.integers(1, size + 1))
    new, values = offspring(genes, order, best, elite, probability, coding, rng)
    assert new.shape == genes.shape
    assert (new[:elite] == genes[order[:elite]]).all()
    assert coding.inside(whole_numbers(new)).all()
    assert (coding.decode(new) == values).all()
    assert new.min() >= 0 and new.max() <= 9
    assert not new[:, ~coding.signed, 0].any()


@given(st.integers(0, 2**32), st.integers(2, 40))
@settings(max_examples=40)
def test_gene_by_gene_or_on_arrays_the_bits_are_the_same(seed: int, size: int) -> None:
    arrays, loops = genetic_operators._offspring_on_arrays, genetic_operators._offspring_in_loops
    rng = np.random.default_rng(seed)
    genes = CODING.first_population(rng.random((size, 3)))
    elite = max(1, size // 3)
    arguments = (
        genes, rng.permutation(size), max(1, size // 2), elite, 0.3, CODING.lowest, CODING.highest,
        CODING.signed, CODING.lower, CODING.upper, CODING.scale,
        *Draws.of(size - elite, 3, 6, rng),
    )  # fmt: skip
    one, other = arrays(*arguments), loops(*arguments)
    compiled = genetic_operators._offspring(*arguments)
    for k in (0, 1):
        assert one[k].dtype == other[k].dtype == compiled[k].dtype
        assert (one[k] == other[k]).all() and (one[k] == compiled[k]).all()


def test_with_an_elite_the_best_never_gets_worse() -> None:
    rng = np.random.default_rng(6)
    target = np.array([2.05, 1.1, -0.13])

    def cost(values: Any) -> Any:
        return ((values - target) ** 2).sum(axis=1)

    genes = CODING.first_population(rng.random((60, 3)))
    costs = [cost(CODING.decode(genes))]
    for _ in range(40):
        order = np.argsort(costs[-1], kind='stable')
        genes, values = offspring(genes, order, 20, 3, 0.2, CODING, rng)
        costs.append(cost(values))
    best = [float(each.min()) for each in costs]
    assert all(b <= a for a, b in pairwise(best))
    assert best[-1] < 1e-4 < best[0]
