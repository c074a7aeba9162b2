"""Tests of obs_ros.optimization.initial_population."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.stats import kstest

from obs_ros.optimization.initial_population import (
    MAPS,
    POPULATIONS,
    check_population,
    cubic,
    first_population,
)


@pytest.mark.parametrize('kind', POPULATIONS)
class TestEveryPopulation:
    def test_it_lies_in_the_box_and_no_two_individuals_are_the_same(self, kind: str) -> None:
        z = first_population(kind, 500, 7, np.random.default_rng(1))
        assert z.shape == (500, 7)
        assert z.min() >= 0.0 and z.max() <= 1.0
        assert len(np.unique(z, axis=0)) == 500

    def test_it_fills_the_box(self, kind: str) -> None:
        z = first_population(kind, 2000, 3, np.random.default_rng(2))
        for column in z.T:
            shares, _ = np.histogram(column, bins=10, range=(0.0, 1.0))
            assert shares.min() > 60, shares  # 200 if it were uniform
            assert abs(column.mean() - 0.5) < 0.05

    def test_dimensions_are_not_correlated(self, kind: str) -> None:
        z = first_population(kind, 2000, 4, np.random.default_rng(3))
        correlation = np.corrcoef(z.T) - np.eye(4)
        assert np.abs(correlation).max() < 0.1

    def test_the_seed_decides(self, kind: str) -> None:
        a, b, c = (first_population(kind, 9, 2, np.random.default_rng(s)) for s in (4, 4, 5))
        np.testing.assert_array_equal(a, b)
        assert not np.array_equal(a, c)


@pytest.mark.parametrize('kind', ['cubic', 'logistic', 'tent', 'sine'])
def test_a_map_runs_from_individual_to_individual(kind: str) -> None:
    z = first_population(kind, 20, 3, np.random.default_rng(6))
    for before, after in pairwise(z):
        np.testing.assert_allclose([MAPS[kind](x) for x in before], after, atol=1e-12)


def test_the_cubic_map_is_the_papers() -> None:
    for w in (-0.9, -0.3, 0.2, 0.7):
        assert 2.0 * cubic((w + 1.0) / 2.0) - 1.0 == pytest.approx(4.0 * w**3 - 3.0 * w, abs=1e-14)


@pytest.mark.parametrize('kind', ['cubic', 'logistic'])
def test_even_makes_the_map_uniform(kind: str) -> None:
    rng = np.random.default_rng(7)
    even = first_population(kind, 4000, 1, rng, even=True)[:, 0]
    raw = first_population(kind, 4000, 1, rng)[:, 0]
    assert kstest(even, 'uniform').statistic < 0.03
    assert kstest(raw, 'uniform').statistic > 0.1


def test_an_unknown_kind_is_refused_with_a_hint() -> None:
    with pytest.raises(ValueError, match="unknown chaotic map 'cubik': did you mean 'cubic'"):
        check_population('cubik')
