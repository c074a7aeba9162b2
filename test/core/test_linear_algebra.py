"""Linear algebra answers with NaN where it has no answer."""

import numpy as np
import pytest

from obs_ros.core.linear_algebra import (
    cholesky,
    eigen,
    inverse_and_log_determinant,
    inverted,
    log_determinant,
    projected_out,
    scaled_inverse,
    singular,
)

MATRIX = np.array([[2.0, 1.0], [1.0, 2.0]])
SINGULAR = np.array([[1.0, 1.0], [1.0, 1.0]])


def test_a_symmetric_matrix_has_its_eigenvalues_inverse_and_root() -> None:
    values, vectors = eigen(MATRIX)
    np.testing.assert_allclose(values, [1.0, 3.0], rtol=1e-14)
    np.testing.assert_allclose(vectors @ np.diag(values) @ vectors.T, MATRIX, rtol=1e-14)
    np.testing.assert_allclose(inverted(MATRIX), [[2 / 3, -1 / 3], [-1 / 3, 2 / 3]], rtol=1e-14)
    root = cholesky(MATRIX)
    assert root[0, 1] == 0.0
    np.testing.assert_allclose(root @ root.T, MATRIX, rtol=1e-14)


def test_a_singular_matrix_has_no_inverse_and_one_that_is_not_positive_no_root() -> None:
    assert np.isnan(inverted(SINGULAR)).all() and inverted(SINGULAR).shape == (2, 2)
    assert np.isnan(cholesky(-MATRIX)).all()
    np.testing.assert_allclose(eigen(SINGULAR)[0], [0.0, 2.0], atol=1e-15)


@pytest.mark.parametrize('wrong', [np.nan, np.inf])
def test_what_is_not_finite_has_no_eigenvalues(wrong: float) -> None:
    values, vectors = eigen(MATRIX * wrong)
    assert np.isnan(values).all() and np.isnan(vectors).all() and vectors.shape == (2, 2)


def test_the_inverse_of_badly_scaled_matrices() -> None:
    scale = np.array([1e-8, 1.0, 1e9])
    core = np.array([[2.0, 0.5, 0.1], [0.5, 1.0, 0.2], [0.1, 0.2, 3.0]])
    found = scaled_inverse(core * np.outer(scale, scale))
    np.testing.assert_allclose(found * np.outer(scale, scale), np.linalg.inv(core), atol=1e-12)


def test_singular_values_of_a_tall_matrix_and_of_one_that_is_not_finite() -> None:
    tall = np.vstack([MATRIX, [[0.0, 1.0]]])
    left, s, right = singular(tall)
    np.testing.assert_allclose((left * s) @ right, tall, atol=1e-14)
    wrong = tall.copy()
    wrong[2, 0] = np.inf
    shapes = [part.shape for part in singular(wrong)]
    assert shapes == [(3, 2), (2,), (2, 2)]
    assert all(np.isnan(part).all() for part in singular(wrong))


def test_columns_lose_what_others_explain_of_them() -> None:
    base, column = np.array([[1.0], [1.0], [1.0]]), np.array([[1.0], [2.0], [6.0]])
    np.testing.assert_allclose(projected_out(base, column)[:, 0], [-2.0, -1.0, 3.0], atol=1e-14)
    assert np.isnan(projected_out(base * np.nan, column)).all()


def test_the_logarithm_of_a_determinant() -> None:
    assert log_determinant(MATRIX) == pytest.approx(np.log(3.0))
    assert log_determinant(np.zeros((2, 2))) == -np.inf
    assert np.isnan(log_determinant(MATRIX * np.nan))


@pytest.mark.parametrize('least', [0.5, 1e-9])
def test_inverse_and_determinant_are_those_of_each_alone(least: float) -> None:
    matrix = np.array([[1.0, 1.0 - least], [1.0 - least, 1.0]])
    inverse, found = inverse_and_log_determinant(matrix)
    np.testing.assert_array_equal(inverse, scaled_inverse(matrix))
    assert found == log_determinant(matrix)
    assert found == pytest.approx(np.log(least * (2.0 - least)), rel=1e-6)
