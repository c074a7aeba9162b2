"""A genetic algorithm over a window, as Gremling & Passino 2000 have it, finished by least squares.

Its digits resolve the box coarsely and its last steps are luck; Levenberg-Marquardt from its elite
takes what it found to the optimum, where the fitness is a sum of squares.
"""

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from obs_ros.core.deadline import Deadline
from obs_ros.core.registry import suggest
from obs_ros.core.typing import Array, IntArray
from obs_ros.optimization import real_coded
from obs_ros.optimization.acceptance import Acceptance
from obs_ros.optimization.decimal_coding import Base10
from obs_ros.optimization.differential_evolution import check_count
from obs_ros.optimization.genetic_operators import among_best
from obs_ros.optimization.initial_population import BLOCKS, costs_in_time, first_population
from obs_ros.optimization.levenberg_marquardt import (
    LM_DEFAULTS,
    LMSettings,
    levenberg_marquardt,
    optimum_width,
)
from obs_ros.optimization.problem import Problem
from obs_ros.optimization.result import Effort, Found
from obs_ros.optimization.trait_breeding import offspring

Coding = Literal['base10', 'real']


@dataclass(frozen=True)
class GASettings:
    """N, D, rho D and p_m of the paper (section 4.2), on a smaller population.

    `coding` is `base10`, strings of `digits` decimal digits, or `real`. With `polish`, the elite is
    taken to the optimum by Levenberg-Marquardt where the fitness is a sum of squares.
    """

    coding: Coding = 'base10'
    population: int = 100
    generations: int = 40
    parents: int = 35
    elite: int = 5
    mutation: float = 0.2
    digits: int = 6
    polish: bool = True
    polish_iterations: int = 120  # rollouts at most
    local: LMSettings = LM_DEFAULTS

    def __post_init__(self) -> None:
        if self.coding not in get_args(Coding):
            known = get_args(Coding)
            raise ValueError(f'unknown coding {self.coding!r}: {suggest(self.coding, known)}')
        check_count('population', self.population, 4)
        check_count('generations', self.generations, 0)
        check_breeding(self.population, self.parents, self.elite, self.mutation)
        check_count('digits', self.digits, 2)
        check_count('polish_iterations', self.polish_iterations, 1)
        if not isinstance(self.polish, bool):
            raise ValueError(f'polish must be true or false, not {self.polish!r}')


def check_breeding(population: int, parents: int, elite: int, mutation: float) -> None:
    """Raise ValueError unless 1 <= elite < N, 2 <= D <= N and 0 < p_m <= 1."""
    check_count('parents', parents, 2)
    check_count('elite', elite, 1)
    if parents > population:
        raise ValueError(f'parents {parents} are more than the population of {population}')
    if elite >= population:
        raise ValueError(f'elite {elite} leaves no room in the population of {population}')
    if not 0.0 < mutation <= 1.0:
        raise ValueError(f'mutation probability {mutation} is outside (0, 1]')


def ga_search(
    objective: Problem,
    rng: np.random.Generator,
    deadline: Deadline,
    settings: GASettings,
    warm: Array | None = None,
    noise_known: bool = False,
) -> Found:
    """Evolve a random population; `warm` (d,), the previous estimate, is one of its candidates.

    It spends its generations, or the time until the deadline. Polished, it believes in an optimum
    at which half of the elite and as many others end; else in none: an elite gathers anywhere.
    """
    z = first_population(
        'uniform', settings.population, objective.dimension, rng, deadline=deadline
    )
    best, cost = np.full(objective.dimension, 0.5), np.inf
    if warm is not None:
        # As it is: digits would round it, and it may lie outside the box where that has no limit.
        best, cost = warm, float(objective.costs(warm[None])[0])
        z[0] = np.clip(warm, 0.0, 1.0)
    population, costs = _begun(objective, z, settings, rng, deadline)
    generation = 0
    while generation < settings.generations and not deadline.passed:
        order = np.argsort(costs, kind='stable')
        population.breed(order)
        children = costs_in_time(objective, population.z[settings.elite :], deadline)
        costs = np.concatenate([costs[order[: settings.elite]], children])
        generation += 1
    order = np.argsort(costs, kind='stable')
    elite = population.z[order[: settings.elite]]
    if costs[order[0]] < cost:
        best, cost = elite[0], float(costs[order[0]])
    effort = Effort(generation, 'generation')
    wanted = settings.polish and objective.is_least_squares and np.isfinite(cost)
    if wanted and not deadline.passed:
        others = population.z[rng.permutation(order[settings.elite :])[: settings.elite]]
        starts = np.vstack([best, elite, others])
        return _polished(objective, starts, best, cost, deadline, settings, effort)
    return Found(best, cost, converged=False, accepted=None, effort=effort)


def _begun(
    objective: Problem, z: Array, settings: GASettings, rng: np.random.Generator, deadline: Deadline
) -> tuple['_Strings | _Reals', Array]:
    """Return the population of points (N, d) and their costs: of as many as there is time for."""
    coded = _Strings if settings.coding == 'base10' else _Reals
    costs: list[Array] = []
    for first in range(0, len(z), BLOCKS.points):
        if first and deadline.passed:
            break
        costs.append(objective.costs(coded(z[first : first + BLOCKS.points], settings, rng).z))
    reached = np.concatenate(costs)
    return coded(z[: reached.size], settings, rng), reached


def _polished(
    objective: Problem,
    starts: Array,
    best: Array,
    cost: float,
    deadline: Deadline,
    settings: GASettings,
    effort: Effort,
) -> Found:
    """Take the starts (P, d) to their optima, and believe in the best if half of them end there."""
    ends = levenberg_marquardt(
        objective, starts, objective.nodes, settings.polish_iterations, deadline,
        settings=settings.local,
    )  # fmt: skip
    squares, converged = float(ends.squares[0]), bool(ends.converged[0])
    agreeing = ends.agreeing(squares, optimum_width(objective, squares, settings.local))
    agree = converged and 2 * agreeing >= len(starts) and not deadline.passed
    accepted = Acceptance.POLISHED if agree else None
    if squares < cost:
        best, cost = ends.z[0], squares
    return Found(best, cost, converged, accepted, effort)


class _Strings:
    """Points z (N, d) of the unit box as strings of digits."""

    def __init__(self, z: Array, settings: GASettings, rng: np.random.Generator) -> None:
        d = z.shape[1]
        self._coding = Base10.of(np.zeros(d), np.ones(d), settings.digits)
        self._genes = self._coding.encode(z)
        self._settings, self._rng = settings, rng

    @property
    def z(self) -> Array:
        return self._coding.decode(self._genes)

    def breed(self, order: IntArray) -> None:
        """Put the next generation in its place, the elite first."""
        s = self._settings
        self._genes, _ = offspring(
            self._genes, order, s.parents, s.elite, s.mutation, self._coding, self._rng
        )


class _Reals:
    """Points z (N, d) of the unit box as they are."""

    def __init__(self, z: Array, settings: GASettings, rng: np.random.Generator) -> None:
        self.z = z
        self._settings, self._rng = settings, rng

    def breed(self, order: IntArray) -> None:
        """Put the next generation in its place, the elite first."""
        s = self._settings
        children = len(self.z) - s.elite
        pairs = among_best(order, s.parents, self._rng.random(((children + 1) // 2, 2)))
        bred = real_coded.offspring(self.z, pairs, s.mutation, self._rng, children)
        self.z = np.vstack([self.z[order[: s.elite]], bred])
