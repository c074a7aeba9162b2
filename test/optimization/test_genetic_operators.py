"""Tests of obs_ros.optimization.genetic_operators."""

from typing import Any

import numpy as np
import pytest

from obs_ros.optimization.decimal_coding import Base10, Genes
from obs_ros.optimization.genetic_operators import (
    among_best,
    copies_of_best,
    fitness_of,
    mutated,
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
