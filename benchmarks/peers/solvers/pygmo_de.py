"""pygmo's differential evolutions on our compiled rollouts, candidate by candidate."""

from collections.abc import Callable

import numpy as np
import pygmo

from benchmarks.peers.problem import Oracle, Problem
from benchmarks.peers.registry import Solve
from obs_ros.core.typing import Array

POPULATION = 32
GENERATIONS = 100000  # its own tolerances, or the oracle, stop it before
FAILED = 1e12


class Fitness:
    """A window as pygmo wants it."""

    def __init__(self, oracle: Oracle) -> None:
        self.oracle = oracle

    # pygmo copies its problems; the oracle must stay the one.
    def __deepcopy__(self, memo: object) -> 'Fitness':
        return self

    def fitness(self, z: Array) -> list[float]:
        """Return the cost of one point."""
        return [min(float(self.oracle.costs(np.asarray(z)[None])[0]), FAILED)]

    def get_bounds(self) -> tuple[list[float], list[float]]:
        """Return the unit box."""
        d = self.oracle.problem.d
        return [0.0] * d, [1.0] * d


def de(problem: Problem) -> Solve:
    """Differential evolution."""
    return solving(pygmo.de)


def sade(problem: Problem) -> Solve:
    """Self-adaptive differential evolution (jDE)."""
    return solving(pygmo.sade)


def de1220(problem: Problem) -> Solve:
    """Self-adaptive differential evolution that mixes its mutations (pDE)."""
    return solving(pygmo.de1220)


def solving(method: Callable[..., object]) -> Solve:
    """Run a method from fresh populations until the oracle stops it."""

    def solve(oracle: Oracle, seed: int) -> None:
        problem = pygmo.problem(Fitness(oracle))
        attempt = seed
        while True:
            population = pygmo.population(problem, POPULATION, seed=attempt)
            pygmo.algorithm(method(gen=GENERATIONS, seed=attempt)).evolve(population)
            attempt += 1000000

    return solve
