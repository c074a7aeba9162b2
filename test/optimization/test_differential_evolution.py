"""Tests of obs_ros.optimization.differential_evolution."""

import math
import re
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from obs_ros.optimization.differential_evolution import DifferentialEvolution


def sphere(z: Any) -> Any:
    return ((z - 0.3) ** 2).sum(axis=1)


def evolution(size: int = 20, dimension: int = 3, seed: int = 0, **changes: Any) -> Any:
    rng = np.random.default_rng(seed)
    return DifferentialEvolution(rng.random((size, dimension)), rng, **changes)


def test_the_first_candidates_are_the_population_itself() -> None:
    population = np.random.default_rng(1).random((5, 2))
    search = DifferentialEvolution(population, np.random.default_rng(2))
    np.testing.assert_array_equal(search.ask(), population)
    search.tell(sphere(population))
    assert search.best[1] == sphere(population).min()


@pytest.mark.parametrize(('strategy', 'generations'), [('rand/1/bin', 150), ('best/1/bin', 60)])
def test_it_converges(strategy: str, generations: int) -> None:
    search = evolution(strategy=strategy)
    for _ in range(generations):
        search.tell(sphere(search.ask()))
    best, cost = search.best
    np.testing.assert_allclose(best, 0.3, atol=1e-4)
    assert cost == sphere(best[None])[0]


@settings(max_examples=40)
@given(
    size=st.integers(4, 30),
    dimension=st.integers(1, 8),
    weight=st.floats(0.01, 2.0),
    crossover=st.floats(0.0, 1.0),
    strategy=st.sampled_from(['rand/1/bin', 'best/1/bin']),
    seed=st.integers(0, 100),
)
def test_candidates_stay_in_the_box_and_costs_never_rise(
    size: int, dimension: int, weight: float, crossover: float, strategy: str, seed: int
) -> None:
    search = evolution(size, dimension, seed, weight=weight, crossover=crossover, strategy=strategy)
    for _ in range(6):
        before = search.costs.copy()
        candidates = search.ask()
        assert candidates.shape == (size, dimension)
        assert candidates.min() >= 0.0 and candidates.max() <= 1.0
        search.tell(sphere(candidates))
        assert (search.costs <= before).all()
        np.testing.assert_array_equal(search.costs, sphere(search.population))


@pytest.mark.parametrize('strategy', ['rand/1/bin', 'best/1/bin'])
def test_a_mutant_is_a_base_and_a_weighted_difference_of_others(strategy: str) -> None:
    # With powers of four as population, a mutant tells what it is made of.
    population = 4.0 ** -np.arange(1.0, 7.0)[:, None]
    search = DifferentialEvolution(
        population, np.random.default_rng(3), strategy=strategy, weight=0.5, crossover=1.0
    )
    search.tell(np.arange(6.0))
    for _ in range(50):
        for i, trial in enumerate(search.ask()[:, 0]):
            made = [
                (a, b, c)
                for a in range(6) for b in range(6) for c in range(6)
                if abs(population[a] + 0.5 * (population[b] - population[c]) - trial)[0] < 1e-15
            ]  # fmt: skip
            if not made:  # it was outside the box, and drawn again
                continue
            good = [
                (a, b, c)
                for a, b, c in made
                if i not in (b, c) and b != c and (strategy != 'best/1/bin' or a == 0)
                and (strategy != 'rand/1/bin' or len({a, b, c, i}) == 4)
            ]  # fmt: skip
            assert good, (i, made)


def test_at_least_one_component_is_new() -> None:
    search = evolution(12, 6, crossover=0.0)
    search.tell(sphere(search.ask()))
    changed = (search.ask() != search.population).sum(axis=1)
    assert changed.tolist() == [1] * 12


def test_crossover_is_the_share_of_new_components() -> None:
    search = evolution(200, 50, crossover=0.3)
    search.tell(sphere(search.ask()))
    share = (search.ask() != search.population).mean()
    assert share == pytest.approx(0.3 + 0.7 / 50, abs=0.02)


def test_candidates_that_diverge_never_win() -> None:
    search = evolution()
    search.tell(sphere(search.ask()))
    costs, population = search.costs.copy(), search.population.copy()
    for bad in (np.inf, np.nan):
        search.ask()
        search.tell(np.full(20, bad))
        np.testing.assert_array_equal(search.costs, costs)
        np.testing.assert_array_equal(search.population, population)


def test_what_it_was_given_and_what_it_returns_stay_as_they_are() -> None:
    population = np.random.default_rng(1).random((6, 2))
    copy = population.copy()
    search = DifferentialEvolution(population, np.random.default_rng(2))
    for _ in range(5):
        search.tell(sphere(search.ask()))
    np.testing.assert_array_equal(population, copy)
    best, _ = search.best
    best[:] = 7.0
    assert search.best[0].max() <= 1.0


@pytest.mark.parametrize(
    ('changes', 'message'),
    [
        ({'size': 3}, 'population must be an integer >= 4, not 3'),
        ({'strategy': 'rand/2'}, "strategy 'rand/2' is none of rand/1/bin, best/1/bin"),
        ({'weight': 0.0}, 'differential weight 0.0 is outside (0, 2]'),
        ({'weight': math.nan}, 'differential weight nan is outside (0, 2]'),
        ({'crossover': 1.1}, 'crossover probability 1.1 is outside [0, 1]'),
        ({'crossover': math.nan}, 'crossover probability nan is outside [0, 1]'),
    ],
)
def test_what_is_wrong_is_named(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=re.escape(message)):
        evolution(**changes)
