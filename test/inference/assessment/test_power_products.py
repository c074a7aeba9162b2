"""Tests of obs_ros.inference.assessment.power_products."""

import numpy as np
import pytest

from obs_ros.inference.assessment.power_products import power_product, sparse


@pytest.mark.parametrize(
    ('ratio', 'words'),
    [(-1.0, 'a*b'), (1.0, 'a/b'), (2.0, 'a/b^2'), (-0.5, 'a^2*b'), (1.5, 'a^2/b^3'),
     (0.2, ''), (1.3, ''), (4.0, ''), (float('nan'), '')],
)  # fmt: skip
def test_power_products_are_named_where_they_mean_something(ratio: float, words: str) -> None:
    assert power_product('a', 'b', ratio) == words


def test_sparse_directions_span_the_same_space_with_the_same_places() -> None:
    rng = np.random.default_rng(0)
    first, second = rng.standard_normal((2, 2, 4))
    places: list[int] = []
    rows = sparse(first, places)
    assert np.linalg.matrix_rank(np.concatenate([rows, first])) == 2
    np.testing.assert_allclose(rows[:, places], np.eye(2), atol=1e-12)
    np.testing.assert_allclose(sparse(second, places)[:, places], np.eye(2), atol=1e-12)
