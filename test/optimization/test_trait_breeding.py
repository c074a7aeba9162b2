"""Tests of obs_ros.optimization.trait_breeding."""

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from obs_ros.optimization import trait_breeding
from obs_ros.optimization.decimal_coding import Base10, whole_numbers
from obs_ros.optimization.trait_breeding import Draws, offspring

CODING = Base10.of([1.8, 0.8, -0.2], [2.3, 1.2, 0.2], 5)


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
    whole = whole_numbers(new)
    assert ((coding.lowest <= whole) & (whole <= coding.highest)).all()
    assert (coding.decode(new) == values).all()
    assert new.min() >= 0 and new.max() <= 9
    assert not new[:, ~coding.signed, 0].any()


@given(st.integers(0, 2**32), st.integers(2, 40))
@settings(max_examples=40)
def test_gene_by_gene_or_on_arrays_the_bits_are_the_same(seed: int, size: int) -> None:
    arrays, loops = trait_breeding._offspring_on_arrays, trait_breeding._offspring_in_loops
    rng = np.random.default_rng(seed)
    genes = CODING.first_population(rng.random((size, 3)))
    elite = max(1, size // 3)
    arguments = (
        genes, rng.permutation(size), max(1, size // 2), elite, 0.3, CODING.lowest, CODING.highest,
        CODING.signed, CODING.lower, CODING.upper, CODING.scale,
        rng.bit_generator.random_raw(Draws.words(size - elite, 3, 6)),
    )  # fmt: skip
    one, other = arrays(*arguments), loops(*arguments)
    compiled = trait_breeding._offspring(*arguments)
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
