"""Follow a search: its best point so far against the candidates it has rolled out."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from benchmarks.judge import Judge
from benchmarks.tanks import TankWindow
from obs_ros.core.deadline import Deadline
from obs_ros.core.typing import Array, IntArray
from obs_ros.inference.objective import Fitness, Objective
from obs_ros.inference.parameterisation import Unknowns
from obs_ros.integration.backends import kernels_for
from obs_ros.integration.grid import Grid
from obs_ros.models.three_tank import THREE_TANK
from obs_ros.optimization.methods import method_for

FIRST_EVALUATIONS, LAST_EVALUATIONS, POINTS = 25, 2150, 60


class Watched(Objective):
    """An objective that notes, after every rollout over the whole window, the best point so far."""

    history: list[tuple[int, Array]]
    _least: float = np.inf

    def costs(self, z: Array, nodes: int | None = None) -> Array:
        cost = super().costs(z, nodes)
        return self._note(z, cost) if nodes in (None, self.nodes) else cost

    def block_squares(self, z: Array, prefixes: IntArray) -> Array:
        squares = super().block_squares(z, prefixes)
        if prefixes[-1] == self.nodes:
            self._note(z, squares.sum(axis=0))
        return squares

    def linearise(self, z: Array, h: Array, nodes: int) -> tuple[Array, Array, Array]:
        found = super().linearise(z, h, nodes)
        if nodes == self.nodes:
            self._note(z, found[0])
        return found

    def _note(self, z: Array, cost: Array) -> Array:
        i = int(np.argmin(cost))
        if cost[i] < self._least:
            self._least = float(cost[i])
            self.history.append((self.evaluations, z[i].copy()))
        return cost


class Followed(NamedTuple):
    """Excess of the squares over the optimum, in sigma^2, at rising numbers of candidates."""

    evaluations: IntArray
    excess: Array


def follow(
    window: TankWindow, estimated: Sequence[str], method: str, fitness: Fitness, seed: int
) -> Followed:
    """Search one window for the estimated names, the others given as they truly are."""
    fixed = {name: value for name, value in window.truth.items() if name not in estimated}
    objective = watched(window, estimated, fixed, fitness)
    chosen, settings = method_for(method)
    chosen.search(objective, np.random.default_rng(seed), Deadline(), settings, None, False)
    judge = Judge(THREE_TANK, window.record, objective.unknowns.names, fixed)
    best = judge.optimum(window.truth, 2, seed)
    squares = [float(np.sum(judge.residuals(z) ** 2)) for _, z in objective.history]
    counts = np.geomspace(FIRST_EVALUATIONS, LAST_EVALUATIONS, POINTS)
    seen = np.searchsorted([count for count, _ in objective.history], counts, side='right')
    # Nothing seen yet is no better than anything.
    excess = np.array([np.inf, *squares])[seen] - best
    return Followed(counts.astype(np.int64), excess / window.sigma**2)


def watched(
    window: TankWindow, estimated: Sequence[str], fixed: Mapping[str, float], fitness: Fitness
) -> Watched:
    """Return the objective of `solve_window`, all outputs weighted equally."""
    parameters = [name for name in estimated if name.startswith('p')]
    states = [name for name in estimated if not name.startswith('p')]
    unknowns = Unknowns.of(THREE_TANK, parameters, states, fixed)
    grid = Grid.of(THREE_TANK, window.record, np.full(2, window.sigma))
    objective = Watched(kernels_for(THREE_TANK), grid, unknowns, fitness)
    objective.history = []
    return objective
