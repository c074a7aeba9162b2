"""Small least-squares problems over the unit box, without plants."""

from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np

from obs_ros.core.typing import Array, IntArray

ROUNDING = 1e-9


class Curve:
    """Fit curve(z (B, d), s (K,)) -> (B, K) to y (K,): a `Problem` for the searches."""

    is_least_squares = True

    def __init__(
        self, curve: Callable[[Array, Array], Array], s: Array, y: Array, dimension: int
    ) -> None:
        self.curve, self.s, self.y, self.dimension = curve, s, y, dimension
        self.nodes = s.size
        self.limits = np.array([[0.0] * dimension, [1.0] * dimension])
        self.evaluations = 0

    @property
    def signal(self) -> float:
        return float(np.var(self.y))

    def count(self, nodes: int) -> int:
        return nodes

    def floor(self, nodes: int) -> float:
        return ROUNDING**2 * float(np.sum(self.y[:nodes] ** 2))

    def errors(self, z: Array) -> Array:
        """Residuals (B, K) of points (B, d)."""
        self.evaluations += len(z)
        return self.curve(z, self.s) - self.y

    def costs(self, z: Array, nodes: int | None = None) -> Array:
        squares = (self.errors(z)[:, :nodes] ** 2).sum(axis=1)
        return np.where(np.isfinite(squares), squares, np.inf)

    def block_squares(self, z: Array, prefixes: IntArray) -> Array:
        squares = self.errors(z) ** 2
        edges = [0, *prefixes]
        blocks = [squares[:, a:b].sum(axis=1) for a, b in pairwise(edges)]
        return np.where(np.isfinite(blocks), blocks, np.inf)

    def linearise(self, z: Array, h: Array, nodes: int) -> tuple[Array, Array, Array]:
        """Central differences, with steps of its own."""
        residual = self.errors(z)[:, :nodes]
        jacobian = np.empty((*residual.shape, z.shape[1]))
        for j in range(z.shape[1]):
            step = np.zeros(z.shape[1])
            step[j] = 1e-6
            jacobian[:, :, j] = (
                self.errors(z + step)[:, :nodes] - self.errors(z - step)[:, :nodes]
            ) / 2e-6
        return (
            (residual**2).sum(axis=1),
            np.einsum('bkj,bk->bj', jacobian, residual),
            np.einsum('bki,bkj->bij', jacobian, jacobian),
        )

    def residuals(self, z: Array) -> Array:
        return self.errors(z[None])[0][:, None]


def decay(z: Array, s: Array) -> Array:
    """Amplitude, rate and offset."""
    a, b, c = z.T[:, :, None]
    return np.asarray(2.0 * a * np.exp(-5.0 * b * s) + c)


def decay_problem(
    truth: tuple[float, float, float] = (0.7, 0.4, 0.2),
    sigma: float = 0.01,
    seed: int = 0,
    nodes: int = 200,
) -> Curve:
    s = np.linspace(0.0, 1.0, nodes)
    noise = sigma * np.random.default_rng(seed).standard_normal(nodes)
    return Curve(decay, s, decay(np.array([truth]), s)[0] + noise, 3)


def ripples(z: Array, s: Array) -> Array:
    """Frequency and phase of a sine: many false minima."""
    frequency, phase = z.T[:, :, None]
    return np.asarray(np.sin(2 * np.pi * (12.0 * frequency * s + phase)))


def ripples_problem(truth: tuple[float, float] = (0.63, 0.3), sigma: float = 0.1) -> Curve:
    s = np.linspace(0.0, 1.0, 300)
    noise = sigma * np.random.default_rng(5).standard_normal(s.size)
    return Curve(ripples, s, ripples(np.array([truth]), s)[0] + noise, 2)


def rows_of(residuals: Callable[[Array], Any], d: int = 2) -> Curve:
    """The least squares of residuals(z (B, d)) -> rows (K, B), over the unit box."""

    def curve(z: Array, _: Array) -> Array:
        return np.asarray(residuals(z)).T

    rows = len(residuals(np.full((1, d), 0.5)))
    return Curve(curve, np.zeros(rows), np.zeros(rows), d)


def linear(seed: int = 0, d: int = 4) -> tuple[Curve, Array, Array]:
    """A problem linear in its unknowns, its optimum (d,) and covariance (d, d)."""
    rng = np.random.default_rng([seed, 3])
    design = 12.0 * rng.standard_normal((20, d))
    noise = rng.standard_normal(20)
    z = np.full(d, 0.5) + np.linalg.lstsq(design, noise, rcond=None)[0]
    covariance = np.linalg.inv(design.T @ design)
    return rows_of(lambda p: design @ (p - 0.5).T - noise[:, None], d), z, covariance
