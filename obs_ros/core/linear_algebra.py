"""Linear algebra that never raises: where it has no answer, the answer is NaN.

Data and models may be anything. A matrix that is not finite or singular, or whose eigenvalues do
not converge, makes deviations NaN, and those are withheld.
"""

import functools
import math

import numpy as np

from obs_ros.core.jit import accelerated, unhurried
from obs_ros.core.typing import Array, ComplexArray

SOUND = 1e-6  # of a diagonal entry, that the others leave: below, eigenvalues tell better


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


def _factored_on_arrays(matrix: Array) -> tuple[Array, float, bool]:
    """Return the same by LAPACK."""
    diagonal = np.diagonal(matrix)
    if not (np.isfinite(matrix).all() and (diagonal > 0.0).all()):
        return np.zeros_like(matrix), 0.0, False
    scale = 1.0 / np.sqrt(diagonal)
    root = cholesky(matrix * np.outer(scale, scale))
    if not (np.diagonal(root) ** 2 > SOUND).all():
        return np.zeros_like(matrix), 0.0, False
    half = np.linalg.inv(root) * scale
    return half.T @ half, float(2.0 * np.log(np.diagonal(root) / scale).sum()), True


def _factored_looped(matrix: Array) -> tuple[Array, float, bool]:
    """Return inverse and log determinant of a positive definite matrix (D, D) by Cholesky's method.

    And whether it is one by far, whatever the scales; else these are 0.
    """
    d = len(matrix)
    root, half, inverse = np.zeros((d, d)), np.zeros((d, d)), np.zeros((d, d))
    scale, total = np.empty(d), 0.0
    for i in range(d):
        if not 0.0 < matrix[i, i] < np.inf:
            return inverse, 0.0, False
        scale[i] = 1.0 / np.sqrt(matrix[i, i])
    for i in range(d):
        for j in range(i + 1):
            value = matrix[i, j] * scale[i] * scale[j]
            for k in range(j):
                value -= root[i, k] * root[j, k]
            if i > j:
                root[i, j] = value / root[j, j]
            elif value > SOUND:  # false for NaN
                root[i, i] = np.sqrt(value)
            else:
                return inverse, 0.0, False
        total += 2.0 * math.log(root[i, i] / scale[i])
    for j in range(d):  # the inverse of the root, column by column
        half[j, j] = 1.0 / root[j, j]
        for i in range(j + 1, d):
            value = 0.0
            for k in range(j, i):
                value -= root[i, k] * half[k, j]
            half[i, j] = value / root[i, i]
    for i in range(d):
        for j in range(i + 1):
            value = 0.0
            for k in range(i, d):
                value += half[k, i] * half[k, j]
            inverse[i, j] = value * scale[i] * scale[j]
            inverse[j, i] = inverse[i, j]
    return inverse, total, True


factored = unhurried(_factored_looped, _factored_on_arrays)


def scaled_inverse(information: Array) -> Array:
    """Return the inverse of a positive definite matrix (D, D), also where scales differ wildly."""
    inverse, _, sound = factored(np.ascontiguousarray(information))
    return inverse if sound else _inverse_by_eigenvalues(information)


def inverse_and_log_determinant(information: Array) -> tuple[Array, float]:
    """Return `scaled_inverse` and `log_determinant` of a matrix (D, D)."""
    inverse, found, sound = factored(np.ascontiguousarray(information))
    if sound:
        return inverse, float(found)
    return _inverse_by_eigenvalues(information), _log_determinant_by_pivots(information)


def _inverse_by_eigenvalues(information: Array) -> Array:
    """Return the inverse of a matrix (D, D) that is hardly positive definite, or not."""
    scale = 1.0 / np.sqrt(np.diagonal(information))
    scaled = information * np.outer(scale, scale)
    values, vectors = eigen(scaled)
    vectors *= scale[:, None]
    return np.asarray((vectors / np.maximum(values, 1e-14)) @ vectors.T)


def _cholesky_on_arrays(matrix: Array) -> Array:
    """Return the same by LAPACK."""
    try:
        return np.asarray(np.linalg.cholesky(matrix))
    except np.linalg.LinAlgError:
        return np.full(matrix.shape, np.nan)


def _cholesky_looped(matrix: Array) -> Array:
    """Return the lower triangle (D, D) whose square is a positive definite matrix (D, D)."""
    d = len(matrix)
    root = np.zeros((d, d))
    for i in range(d):
        for j in range(i + 1):
            value = matrix[i, j]
            for k in range(j):
                value -= root[i, k] * root[j, k]
            if i > j:
                root[i, j] = value / root[j, j]
            elif 0.0 < value < np.inf:
                root[i, i] = np.sqrt(value)
            else:
                root[:] = np.nan
                return root
    return root


cholesky = accelerated(_cholesky_looped, _cholesky_on_arrays)


@functools.cache
def prepare() -> None:
    """Compile what is above, or load it compiled."""
    factored(np.ones((1, 1)))
    cholesky(np.ones((1, 1)))


def log_determinant(matrix: Array) -> float:
    """Return the logarithm of the absolute determinant of a matrix (D, D); -inf if singular.

    The matrix is symmetric.
    """
    _, found, sound = factored(np.ascontiguousarray(matrix))
    return float(found) if sound else _log_determinant_by_pivots(matrix)


def _log_determinant_by_pivots(matrix: Array) -> float:
    """Return the logarithm of the absolute determinant of any matrix (D, D)."""
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
