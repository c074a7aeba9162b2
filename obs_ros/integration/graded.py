"""Grids whose steps begin short and double: they resolve what decays fast after each node.

A linearly implicit method damps a fast motion whether its steps resolve it or not. Where that
motion moves slower ones on its way, as after a start or a leap of an input off a slow manifold,
steps and half as long ones err alike, and doubling them shows nothing. Steps in a geometric row
show it at little cost.
"""

import math
from dataclasses import replace

import numpy as np

from obs_ros.core.typing import Array, IntArray
from obs_ros.integration.grid import Grid

MOST_LEVELS = 24  # a step over 2^24: what is faster leaves no trace in floats


def levels(longest: float, fastest: float) -> int:
    """Return how often the longest step (s) is halved to resolve the fastest rate (1/s)."""
    if not (math.isfinite(fastest) and longest * fastest > 1.0):
        return 0
    return min(MOST_LEVELS, math.ceil(math.log2(longest * fastest)))


def graded(grid: Grid, halvings: int) -> tuple[Grid, IntArray]:
    """Return a grid whose first step of each interval is graded, and where its nodes (K,) are now.

    That step becomes 2^-halvings, ..., 1/4, 1/2 of it; nothing is measured at the nodes between.
    The grid must not be corrected (see `Injection`).
    """
    dt = np.diff(grid.t)
    h = dt / grid.steps
    shares = np.append(0.0, 0.5 ** np.arange(halvings, -1, -1))  # of the first step
    after = h[:, None] * shares  # (K - 1, halvings + 2)
    kept = np.ones(after.shape, dtype=bool)
    kept[:, -1] = grid.steps > 1
    steps = np.ones(after.shape, dtype=np.int64)
    steps[:, -1] = grid.steps - 1
    interval = np.repeat(np.arange(dt.size), kept.sum(axis=1))
    after = after[kept]
    nodes = np.append(np.cumsum(kept.sum(axis=1)) - kept.sum(axis=1), after.size)

    def spread(values: Array) -> Array:
        """Return values (K, any) at their nodes, 0 between."""
        all_nodes = np.zeros((after.size + 1, *values.shape[1:]), dtype=values.dtype)
        all_nodes[nodes] = values
        return all_nodes

    between = replace(
        grid,
        t=np.append(grid.t[interval] + after, grid.t[-1]),
        steps=steps[kept],
        u=np.vstack([grid.u[interval] + after[:, None] * grid.slope[interval], grid.u[-1:]]),
        slope=np.vstack([grid.slope[interval], grid.slope[-1:]]),
        y=spread(grid.y),
        weight=spread(grid.weight),
        measured=np.isin(np.arange(after.size + 1), nodes[grid.measured]),
        ends=None,
    )
    return between, nodes
