"""Tests of obs_ros.optimization.roulette_breeding."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from obs_ros.core.typing import Array
from obs_ros.optimization import roulette_breeding
from obs_ros.optimization.decimal_coding import Base10, Genes, whole_numbers
from obs_ros.optimization.genetic_operators import chosen_by, copies_of_best, wheel_of
from obs_ros.optimization.roulette_breeding import next_generation

CODING = Base10.of([0.0, -9.9], [9.9, -0.01], 7, signed=True)  # of Porter & Passino, section 4.2
WIDE = Base10.of([-9.9, -9.9], [9.9, 9.9], 7, signed=True)
FORMS = {
    'arrays': roulette_breeding._bred_on_arrays,
    'loops': roulette_breeding._bred_in_loops,
    'compiled': roulette_breeding._bred,
}


@pytest.fixture(params=FORMS)
def form(request: Any, monkeypatch: pytest.MonkeyPatch) -> str:
    monkeypatch.setattr(roulette_breeding, '_bred', FORMS[request.param])
    return str(request.param)


def population(seed: int, size: int) -> tuple[Genes, Array]:
    """Genes of random strings, and fitness of which some is nearly all."""
    rng = np.random.default_rng(seed)
    return CODING.first_population(rng.random((size, 2))), rng.random(size) ** 8


def bred(
    genes: Genes, fitness: Array, seed: int, mutation: float = 0.4, tries: int = 0,
    crossover: float = 0.6, coding: Base10 = CODING,
) -> tuple[Genes, Array]:  # fmt: skip
    best, rng = int(fitness.argmax()), np.random.default_rng(seed)
    return next_generation(coding, genes, fitness, best, crossover, mutation, tries, rng)


@given(st.integers(0, 2**32), st.integers(2, 40), st.integers(0, 4), st.floats(0.01, 1.0))
@settings(max_examples=20)
def test_gene_by_gene_or_on_arrays_the_bits_are_the_same(
    seed: int, size: int, tries: int, mutation: float
) -> None:
    genes, fitness = population(seed, size)
    found = []
    for each in FORMS.values():
        rng = np.random.default_rng(seed)
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(roulette_breeding, '_bred', each)
            new, values = next_generation(CODING, genes, fitness, 0, 0.6, mutation, tries, rng)
        found.append((new.tobytes(), values.tobytes(), rng.random()))  # as many draws, too
    assert found[0] == found[1] == found[2]
    assert new.dtype == np.int8 and new.shape == genes.shape
    assert (CODING.decode(new) == values).all()


def test_the_best_leaves_its_copies_as_they_are(form: str) -> None:
    genes, fitness = population(1, 20)
    genes[fitness.argmax(), 0] = [1, *[0] * 7]  # minus zero, which no number tells
    copies = copies_of_best(fitness)
    new, values = bred(genes, fitness, 2)
    assert copies > 1 and (new[:copies] == genes[fitness.argmax()]).all()
    assert (values[:copies] == CODING.decode(genes)[fitness.argmax()]).all()
    assert np.unique(new[copies:].reshape(20 - copies, -1), axis=0).shape[0] > 1


def test_children_are_clamped_to_their_ranges_where_they_never_are_inside(form: str) -> None:
    genes, fitness = population(3, 400)
    shares = []
    for tries in (0, 1, 10):
        whole = whole_numbers(bred(genes, fitness, 4, tries=tries)[0])
        assert ((CODING.lowest <= whole) & (whole <= CODING.highest)).all()
        shares.append(float(((whole == CODING.lowest) | (whole == CODING.highest)).mean()))
    assert shares[0] > 1.2 * shares[1] > 1.2 * 1.2 * shares[2] > 0.0


def test_only_children_outside_are_bred_again(form: str) -> None:
    genes, fitness = population(5, 20)
    (once, _), (again, _) = (bred(genes, fitness, 6, tries=tries) for tries in (0, 1))
    whole = whole_numbers(once)
    free = ((whole > CODING.lowest) & (whole < CODING.highest)).all(axis=1)
    assert 4 < free.sum() < 16
    assert (once[free] == again[free]).all()
    assert (once[~free] != again[~free]).any()


def test_children_neither_crossed_nor_mutated_are_their_parents(form: str) -> None:
    genes, _ = population(7, 21)
    fitness = np.linspace(1.0, 1.2, 21)
    new, _ = bred(genes, fitness, 8, mutation=1e-12, crossover=0.0)
    parents = chosen_by(wheel_of(fitness), np.random.default_rng(8).random((10, 2)))
    assert (new[1:] == genes[parents.T.ravel()]).all()


def test_genes_come_from_both_parents_and_mutate_to_all_digits(form: str) -> None:
    genes = np.zeros((2000, 2, 8), dtype=np.int8)
    genes[::2] = 1
    crossed, _ = bred(genes, np.ones(2000), 9, mutation=1e-12, crossover=1.0, coding=WIDE)
    assert crossed[1:, :, 1:].mean() == pytest.approx(0.5, abs=0.05)
    assert (crossed[1:, 0, 0] != crossed[1:, 1, 7]).mean() == pytest.approx(0.5, abs=0.05)
    mutated, _ = bred(genes, np.ones(2000), 10, mutation=0.5, tries=10, coding=WIDE)
    digits = np.bincount(mutated[1:, 1, 3:].ravel(), minlength=10) / (1999 * 5)
    np.testing.assert_allclose(digits, [0.3] * 2 + [0.05] * 8, atol=0.03)
