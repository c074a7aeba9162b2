"""Calls of the compiled kernels in which candidates take steps of their own."""

import functools
from types import ModuleType

import numpy as np

from obs_ros.core.model import Model
from obs_ros.core.typing import AnyArray, Array, IntArray
from obs_ros.integration.grid import Grid
from obs_ros.integration.own_steps import Layout, floors
from obs_ros.integration.path import always


def squares(
    module: ModuleType, model: Model, grid: Grid, prefixes: IntArray, x0: Array, p: Array
) -> Array:
    """See `Kernels.squares`."""
    layout, x, q = laid(x0, p[None], 1)
    out = np.empty((prefixes.size, len(model.outputs), x.shape[1]))
    module.squares_own(
        *_axis(grid), *_measurements(grid), prefixes, x, q, always(grid.t.size)[0], layout.lead,
        *_limits(model, grid), out,
    )  # fmt: skip
    return out[:, :, layout.place]


def grams(
    module: ModuleType, model: Model, grid: Grid, nodes: int, x0: Array, p: Array, width: int
) -> Array:
    """See `Kernels.grams`."""
    layout, x, q = laid(x0, p[None], width)
    out = np.empty((x0.shape[1] // width, width, width))
    module.grams_own(
        *_axis(grid), *_measurements(grid), nodes, x, q, always(grid.t.size)[0], layout.lead,
        layout.place, *_limits(model, grid), out,
    )  # fmt: skip
    return out


def scheduled(
    module: ModuleType, model: Model, grid: Grid, x0: Array, p: Array, along: IntArray,
    there: IntArray, width: int,
) -> tuple[Array, Array, IntArray]:  # fmt: skip
    """Return states and outputs, see `Kernels.scheduled`, and counts of steps (K - 1, B)."""
    layout, x, q = laid(x0, p, width)
    states = np.empty((grid.t.size, *x.shape))
    outputs = np.empty((grid.t.size, len(model.outputs), x.shape[1]))
    counts = np.zeros((grid.t.size - 1, x.shape[1]), dtype=np.int64)
    module.trajectories_own(
        *_axis(grid), x, q, along, there, layout.lead, *_limits(model, grid), states, outputs,
        counts,
    )  # fmt: skip
    place = layout.place
    return states[..., place], outputs[..., place], counts[:, place]


def laid(x0: Array, p: Array, width: int) -> tuple[Layout, Array, Array]:
    """Return how candidates lie in lanes, groups of `width` led by their first, and them so.

    They have states x0 (n, B) and parameters p (..., q, B).
    """
    layout = _layout(x0.shape[1], width)
    x, q = (np.ascontiguousarray(each[..., layout.order]) for each in (x0, p))
    return layout, x, q


_layout = functools.lru_cache(maxsize=256)(Layout.of)
_floors = functools.lru_cache(maxsize=64)(floors)


def _axis(grid: Grid) -> tuple[AnyArray, ...]:
    return grid.clock, grid.fresh, grid.u, grid.slope


def _measurements(grid: Grid) -> tuple[AnyArray, ...]:
    return grid.y, grid.weight, grid.measured, grid.period


def _limits(model: Model, grid: Grid) -> tuple[float, Array, float, int]:
    return grid.tolerance, _floors(model), grid.longest, grid.budget
