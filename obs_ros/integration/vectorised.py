"""Rollouts on NumPy: the same results as the compiled ones, one array entry per candidate."""

from typing import Any

import numpy as np

from obs_ros.core.model import Model
from obs_ros.core.typing import Array, IntArray
from obs_ros.integration.grid import Grid
from obs_ros.integration.steps import STEPS


class NumpyKernels:
    """Rolls candidates out without a compiler; an order of magnitude or two slower."""

    name = 'numpy'
    compile_time = 0.0

    def __init__(self, model: Model) -> None:
        self.model = model
        self.step = STEPS[model.integrator]

    def squares(self, grid: Grid, prefixes: IntArray, x0: Array, p: Array) -> Array:
        """See `Kernels.squares`."""
        total = np.zeros((prefixes.size, len(self.model.outputs), x0.shape[1]))
        block = np.searchsorted(prefixes, np.arange(prefixes[-1]), side='right')
        for k, _, y in self._nodes(grid, int(prefixes[-1]), x0, p):
            if grid.measured[k]:
                for i, yi in enumerate(y):
                    total[block[k], i] += (grid.weight[k, i] * (yi - grid.y[k, i])) ** 2
        return total

    def grams(self, grid: Grid, nodes: int, x0: Array, p: Array, width: int) -> Array:
        """See `Kernels.grams`."""
        starts = x0.shape[1] // width
        total = np.zeros((starts, width, width))
        for k, _, y in self._nodes(grid, nodes, x0, p):
            if grid.measured[k]:
                for i, yi in enumerate(y):
                    lanes = grid.weight[k, i] * np.broadcast_to(yi, x0.shape[1:])
                    lanes = lanes.reshape(starts, width)
                    row = lanes - lanes[:, :1]
                    row[:, 0] = lanes[:, 0] - grid.weight[k, i] * grid.y[k, i]
                    total += row[:, :, None] * row[:, None, :]
        return total

    def trajectories(self, grid: Grid, x0: Array, p: Array) -> tuple[Array, Array]:
        """See `Kernels.trajectories`."""
        states = np.empty((grid.t.size, *x0.shape))
        outputs = np.empty((grid.t.size, len(self.model.outputs), x0.shape[1]))
        for k, x, y in self._nodes(grid, grid.t.size, x0, p):
            for i, xi in enumerate(x):
                states[k, i] = xi
            for i, yi in enumerate(y):
                outputs[k, i] = yi
        return states, outputs

    def _nodes(self, grid: Grid, nodes: int, x0: Array, p: Array) -> Any:
        """Yield node, states and outputs along the grid; silent about candidates that diverge."""
        x, parameters = tuple(x0), tuple(p)
        with np.errstate(all='ignore'):
            for k in range(nodes):
                if k > 0:
                    x = self._advance(grid, k - 1, x, parameters)
                yield k, x, self.model.output(grid.t[k], x, tuple(grid.u[k]), parameters)

    def _advance(self, grid: Grid, k: int, x: Any, p: Any) -> Any:
        h = (grid.t[k + 1] - grid.t[k]) / grid.steps[k]
        for j in range(grid.steps[k]):
            s = j * h
            u0, u1, u2 = (
                tuple(grid.u[k] + after * grid.slope[k]) for after in (s, s + 0.5 * h, s + h)
            )
            x = self.step(self.model.dynamics, grid.t[k] + s, h, x, u0, u1, u2, p)
        return x
