"""A window near one point: its residual and end state, with their derivatives by differences."""

import functools
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from obs_ros.core.jit import unhurried
from obs_ros.core.periods import shortest, shortest_way
from obs_ros.core.typing import Array


@dataclass(frozen=True)
class Linearisation:
    """A window near one point: scaled residual (M,) and end state (n,), and their Jacobians.

    `path` are the states (K, n) and outputs (K, r) of the point itself.
    """

    residual: Array
    jacobian: Array  # (M, D)
    state: Array
    state_jacobian: Array  # (n, D)
    path: tuple[Array, Array]

    @cached_property
    def gram(self) -> Array:
        """The Jacobian's products J'J (D, D)."""
        return np.asarray(self.jacobian.T @ self.jacobian)


def _differences_on_arrays(
    outputs: Array, y: Array, weight: Array, period: Array, taken: Array
) -> tuple[Array, Array]:
    """Return the same on whole arrays."""
    known = weight > 0.0
    factor = weight[known][:, None]
    rows = factor * outputs[known]
    turns = np.broadcast_to(period, known.shape)[known][:, None] * factor
    residual = rows[:, 0] - weight[known] * y[known]
    return residual, shortest(rows[:, 1:] - rows[:, :1], turns) / taken


def _differences(
    outputs: Array, y: Array, weight: Array, period: Array, taken: Array
) -> tuple[Array, Array]:
    """Return the scaled residual (M,) of the first candidate, and differences (M, D) by the others.

    Of outputs (K, r, 1 + D), wherever one was measured, those of candidate j less the first one's
    are divided by taken[j]; all by the shortest way round the periods (r,).
    """
    nodes, count, lanes = outputs.shape
    rows = 0
    for k in range(nodes):
        for i in range(count):
            if weight[k, i] > 0.0:
                rows += 1
    residual, jacobian = np.empty(rows), np.empty((rows, lanes - 1))
    row = 0
    for k in range(nodes):
        for i in range(count):
            factor, turn = weight[k, i], weight[k, i] * period[i]
            if factor > 0.0:
                values, slopes = outputs[k, i], jacobian[row]
                base = factor * values[0]
                residual[row] = base - factor * y[k, i]
                for j in range(lanes - 1):
                    off = factor * values[1 + j] - base
                    if turn > 0.0:
                        off = shortest_way(off, turn)
                    slopes[j] = off / taken[j]
                row += 1
    return residual, jacobian


differences = unhurried(_differences, _differences_on_arrays, exact=True)


@functools.cache
def prepare() -> None:
    """Compile what is above, or load it compiled."""
    a, one = np.ones(1), np.ones((1, 1))
    shortest_way(1.0, 1.0)
    differences(np.ones((1, 1, 2)), one, one, a, a)
