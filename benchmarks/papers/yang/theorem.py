"""Theorem 1 on a plant with false minima: Lorenz's convection, without noise.

x is measured; y and z at the start and rho are unknown, and told apart by x, so the plant is
observable as the theorem asks. A trial lies at most F extents beyond the population, but for
components beyond a wall of the box, which are drawn again. Once the population has shrunk into one
valley of the distance, far from the walls, no later generation can leave it.
"""

import functools
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from benchmarks.papers.seeds import seeds_of
from benchmarks.runner import monte_carlo
from benchmarks.zoo.lorenz63 import LORENZ63
from obs_ros import Record
from obs_ros.core.typing import Array
from obs_ros.inference.objective import Objective
from obs_ros.inference.parameterisation import Unknowns
from obs_ros.integration.backends import kernels_for
from obs_ros.integration.grid import Grid
from obs_ros.optimization.chaotic_de import ChaoticDESettings
from obs_ros.optimization.differential_evolution import DifferentialEvolution
from obs_ros.optimization.initial_population import first_population

SAMPLES, PERIOD = 3000, 0.01  # s
# On the attractor; the parameters are those of Lorenz 1963.
TRUTH = {'x': -8.0, 'y': -9.0, 'z': 25.0, 'sigma': 10.0, 'rho': 28.0, 'beta': 8.0 / 3.0}
STATES, PARAMETERS = ('y', 'z'), ('rho',)  # that are unknown
SHRUNK = 1e-6  # boxes: the extent of a population that has made its choice
FOUND = 1e-3  # boxes: an individual this near has found the truth
MOST_GENERATIONS = 2000
STARTS = ('cubic', 'uniform')  # first populations


class Collapse(NamedTuple):
    """A search until its population has shrunk.

    `shrunk` and `found` tell whether it has, and whether the best is the truth; `walls` whether
    the best lies within 2 extents of a wall; `rises` counts the generations in which the least
    distance grew, against eq. 11.
    """

    generations: int
    shrunk: bool
    found: bool
    walls: bool
    rises: int

    @property
    def lost(self) -> bool:
        """Whether no later generation can find the truth."""
        return self.shrunk and not self.found and not self.walls


def collapses(seeds: int) -> Mapping[str, Sequence[Collapse]]:
    """Search from a chaotic and from a plain random first population."""
    runs = {
        kind: [(kind, seed) for seed in seeds_of('yang', f'Lorenz from {kind}', seeds)]
        for kind in STARTS
    }
    return monte_carlo(collapse, runs, 'theorem', chunk=25)


def collapse(kind: str, seed: int) -> Collapse:
    """Search with the paper's constants, for as many generations as it takes."""
    objective, truth = problem()
    rng, paper = np.random.default_rng(seed), ChaoticDESettings()
    search = DifferentialEvolution(
        first_population(kind, paper.population, truth.size, rng),
        rng,
        paper.strategy,
        paper.differential_weight,
        paper.crossover,
    )
    least, rises = np.inf, 0
    while search.generation < MOST_GENERATIONS and extent(search) >= SHRUNK:
        search.tell(objective.costs(search.ask()))
        rises += search.best[1] > least
        least = search.best[1]
    best = search.best[0]
    return Collapse(
        search.generation,
        extent(search) < SHRUNK,
        bool(np.abs(best - truth).max() < FOUND),
        bool(np.minimum(best, 1.0 - best).min() < 2.0 * extent(search)),
        rises,
    )


def extent(search: DifferentialEvolution) -> float:
    """Return the extent of a population in boxes."""
    return float(np.ptp(search.population, axis=0).max())


@functools.cache
def problem() -> tuple[Objective, Array]:
    """Return the distance -f_t1 of points of the unit box, and the true point."""
    t = PERIOD * np.arange(float(SAMPLES))
    kernels, fixed = kernels_for(LORENZ63), {**TRUTH}
    names = [variable.name for variable in LORENZ63.variables]
    values = np.array([TRUTH[name] for name in names])[:, None]
    blank = Record(t, np.empty((t.size, 0)), np.zeros((t.size, 1)))
    _, y = kernels.trajectories(Grid.of(LORENZ63, blank, np.ones(1)), values[:3], values[3:])
    for name in (*STATES, *PARAMETERS):
        del fixed[name]
    unknowns = Unknowns.of(LORENZ63, PARAMETERS, STATES, fixed)
    grid = Grid.of(LORENZ63, Record(t, blank.u, y[:, :, 0]), np.ones(1))
    boxes = [LORENZ63.variable(name) for name in unknowns.names]
    truth = np.array([(TRUTH[box.name] - box.lower) / (box.upper - box.lower) for box in boxes])
    return Objective(kernels, grid, unknowns, 'euclidean'), truth
