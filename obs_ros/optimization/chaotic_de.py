"""Differential evolution from a chaotic population, as Yang, Li & Dahhou 2020 have it."""

from dataclasses import dataclass

import numpy as np

from obs_ros.core.deadline import Deadline
from obs_ros.core.typing import Array
from obs_ros.optimization.acceptance import Acceptance
from obs_ros.optimization.differential_evolution import (
    DifferentialEvolution,
    Strategy,
    check_count,
    check_settings,
)
from obs_ros.optimization.initial_population import (
    check_population,
    costs_in_time,
    first_population,
)
from obs_ros.optimization.problem import Problem
from obs_ros.optimization.result import Effort, Found


@dataclass(frozen=True)
class ChaoticDESettings:
    """The paper's constants (section 5.1): Np, Gm, F and CR."""

    chaos: str = 'cubic'
    population: int = 25
    generations: int = 85
    strategy: Strategy = 'rand/1/bin'
    differential_weight: float = 0.7
    crossover: float = 0.7
    gathered: float = 1e-3  # boxes; a population of no greater extent has converged

    def __post_init__(self) -> None:
        check_population(self.chaos)
        check_settings(self.population, self.strategy, self.differential_weight, self.crossover)
        check_count('generations', self.generations, 0)


def chaotic_de_search(
    objective: Problem,
    rng: np.random.Generator,
    deadline: Deadline,
    settings: ChaoticDESettings,
    warm: Array | None = None,
    noise_known: bool = False,
) -> Found:
    """Evolve a chaotic population; `warm` (d,), the previous estimate, is one of its individuals.

    The others are drawn afresh (section 4.4.2). It spends its generations, or the time until the
    deadline, and has no test of its optimum but that the population has gathered.
    """
    z = first_population(
        settings.chaos, settings.population, objective.dimension, rng, deadline=deadline
    )
    if warm is not None:
        z[0] = warm
    evolution = DifferentialEvolution(
        z, rng, settings.strategy, settings.differential_weight, settings.crossover
    )
    for generation in range(settings.generations + 1):
        if generation > 0 and deadline.passed:
            break
        evolution.tell(costs_in_time(objective, evolution.ask(deadline), deadline))
    best, cost = evolution.best
    gathered = bool(np.ptp(evolution.population, axis=0).max() < settings.gathered)
    return Found(
        z=best,
        cost=cost,
        converged=gathered,
        accepted=Acceptance.GATHERED if gathered else None,
        effort=Effort(evolution.generation - 1, 'generation'),
    )
