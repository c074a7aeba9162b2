"""Linear algebra that never raises: where it has no answer, the answer is NaN.

Data and models may be anything. A matrix that is not finite or singular, or whose eigenvalues do
not converge, makes deviations NaN, and those are withheld.
"""

import numpy as np

from obs_ros.core.typing import Array, ComplexArray


def eigen(matrix: Array) -> tuple[Array, Array]:
    """Return eigenvalues (D,), rising, and eigenvectors (D, D) of a symmetric matrix (D, D)."""
    try:
        if np.isfinite(matrix).all():
            values, vectors = np.linalg.eigh(matrix)
            return values, vectors
    except np.linalg.LinAlgError:
        pass
    return np.full(len(matrix), np.nan), np.full(matrix.shape, np.nan)


def inverted(matrix: Array) -> Array:
    """Return the inverse of a matrix (D, D)."""
    try:
        return np.asarray(np.linalg.inv(matrix))
    except np.linalg.LinAlgError:
        return np.full(matrix.shape, np.nan)


def scaled_inverse(information: Array) -> Array:
    """Return the inverse of a positive definite matrix (D, D), also where scales differ wildly."""
    scale = 1.0 / np.sqrt(np.diagonal(information))
    scaled = information * np.outer(scale, scale)
    values, vectors = eigen(scaled)
    vectors *= scale[:, None]
    return np.asarray((vectors / np.maximum(values, 1e-14)) @ vectors.T)


def cholesky(matrix: Array) -> Array:
    """Return the lower triangle (D, D) whose square is a positive definite matrix (D, D)."""
    try:
        return np.asarray(np.linalg.cholesky(matrix))
    except np.linalg.LinAlgError:
        return np.full(matrix.shape, np.nan)


def log_determinant(matrix: Array) -> float:
    """Return the logarithm of the absolute determinant of a matrix (D, D); -inf if singular."""
    with np.errstate(all='ignore'):
        return float(np.linalg.slogdet(matrix)[1])


def singular(matrix: Array) -> tuple[Array, Array, Array]:
    """Return the thin decomposition U (N, k), s (k,), falling, and V' (k, D) of a matrix (N, D)."""
    try:
        if np.isfinite(matrix).all():
            left, s, right = np.linalg.svd(matrix, full_matrices=False)
            return left, s, right
    except np.linalg.LinAlgError:
        pass
    rank = min(matrix.shape)
    shapes = (len(matrix), rank), (rank,), (rank, matrix.shape[1])
    left, s, right = (np.full(shape, np.nan) for shape in shapes)
    return left, s, right


def projected_out(base: Array, columns: Array) -> Array:
    """Return columns (N, k) less what columns of a base (N, D) explain of them."""
    try:
        if np.isfinite(base).all() and np.isfinite(columns).all():
            return np.asarray(columns - base @ np.linalg.lstsq(base, columns, rcond=None)[0])
    except np.linalg.LinAlgError:
        pass
    return np.full(columns.shape, np.nan)


def poles(matrix: Array) -> ComplexArray:
    """Return the eigenvalues (D,) of a matrix (D, D)."""
    try:
        if np.isfinite(matrix).all():
            return np.asarray(np.linalg.eigvals(matrix), dtype=np.complex128)
    except np.linalg.LinAlgError:
        pass
    return np.full(len(matrix), np.nan, dtype=np.complex128)
