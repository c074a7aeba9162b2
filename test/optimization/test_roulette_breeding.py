"""Tests of obs_ros.optimization.roulette_breeding."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from obs_ros.core.typing import Array
from obs_ros.optimization import roulette_breeding
from obs_ros.optimization.decimal_coding import Base10, Genes, whole_numbers
from obs_ros.optimization.genetic_operators import chosen_by, wheel_of
from obs_ros.optimization.roulette_breeding import bred_until_inside

CODING = Base10.of([0.0, -9.9], [9.9, -0.01], 7, signed=True)  # of Porter & Passino, section 4.2
FORMS = {
    'arrays': roulette_breeding._bred_on_arrays,
    'loops': roulette_breeding._bred_in_loops,
    'compiled': roulette_breeding._bred,
}


@pytest.fixture(params=FORMS)
def form(request: Any, monkeypatch: pytest.MonkeyPatch) -> str:
    monkeypatch.setattr(roulette_breeding, '_bred', FORMS[request.param])
    return str(request.param)


def population(rng: np.random.Generator, size: int) -> tuple[Genes, Array]:
    return CODING.first_population(rng.random((size, 2))), rng.random(size) ** 8


@given(st.integers(0, 2**32), st.integers(2, 40), st.integers(0, 4), st.floats(0.01, 1.0))
@settings(max_examples=40)
def test_gene_by_gene_or_on_arrays_the_bits_are_the_same(
    seed: int, size: int, tries: int, mutation: float
) -> None:
    genes, fitness = population(np.random.default_rng(seed), size)
    found = []
    for each in FORMS.values():
        rng = np.random.default_rng(seed + 1)
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(roulette_breeding, '_bred', each)
            bred = bred_until_inside(CODING, genes, fitness, size - 1, 0.6, mutation, tries, rng)
        found.append((bred, rng.random()))
    (one, after), *others = found
    assert one.dtype == np.int8 and one.shape == (size - 1, 2, 8)
    for other, later in others:
        assert (other == one).all() and other.dtype == one.dtype
        assert later == after  # as many random numbers were drawn


def test_children_are_inside_and_clamped_where_they_never_are(form: str) -> None:
    rng = np.random.default_rng(2)
    genes, fitness = population(rng, 40)
    shares = []
    for tries in (0, 1, 10):
        bred = bred_until_inside(CODING, genes, fitness, 400, 0.6, 0.4, tries, rng)
        whole = whole_numbers(bred)
        assert CODING.inside(whole).all()
        shares.append(float(((whole == CODING.lowest) | (whole == CODING.highest)).mean()))
    assert shares[0] > 1.2 * shares[1] > 1.2 * 1.2 * shares[2] > 0.0


def test_only_children_outside_are_bred_again(form: str) -> None:
    genes, fitness = population(np.random.default_rng(3), 20)
    once, again = (
        bred_until_inside(CODING, genes, fitness, 19, 0.6, 0.4, tries, np.random.default_rng(4))
        for tries in (0, 1)
    )
    bounds = whole_numbers(once)
    free = ((bounds > CODING.lowest) & (bounds < CODING.highest)).all(axis=1)
    assert 0 < free.sum() < 19
    assert (once[free] == again[free]).all()
    assert (once[~free] != again[~free]).any()


def test_uncrossed_and_all_but_never_mutated_children_are_their_first_parents(form: str) -> None:
    genes, fitness = population(np.random.default_rng(5), 20)
    bred = bred_until_inside(CODING, genes, fitness, 10, 0.0, 1e-12, 0, np.random.default_rng(6))
    draws = np.random.default_rng(6).random((5, 2))
    parents = chosen_by(wheel_of(fitness), draws)
    assert (bred == genes[parents.T.ravel()]).all()


def test_genes_come_from_either_parent_or_from_all_digits(form: str) -> None:
    genes = np.zeros((2, 2, 8), dtype=np.int8)
    genes[1] = 1
    wide = Base10.of([-9.9, -9.9], [9.9, 9.9], 7, signed=True)
    bred: Callable[[float], Genes] = lambda mutation: bred_until_inside(  # noqa: E731
        wide, genes, np.ones(2), 4000, 1.0, mutation, 10, np.random.default_rng(7)
    )
    assert bred(1e-12)[:, :, 1:].mean() == pytest.approx(0.5, abs=0.03)
    digits = np.bincount(bred(0.5)[:, 1, 3:].ravel(), minlength=10) / (4000 * 5)
    np.testing.assert_allclose(digits, [0.3] * 2 + [0.05] * 8, atol=0.02)
