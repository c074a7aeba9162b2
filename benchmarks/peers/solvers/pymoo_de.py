"""pymoo's differential evolution on our compiled rollouts, a population at a time."""

from typing import Any

import numpy as np
from pymoo.algorithms.soo.nonconvex.de import DE
from pymoo.core.problem import Problem as PymooProblem
from pymoo.optimize import minimize

from benchmarks.peers.problem import Oracle, Problem
from benchmarks.peers.registry import Solve
from obs_ros.core.typing import Array

POPULATION = 32
GENERATIONS = 3000  # then again from a fresh population
FAILED = 1e12


class Window(PymooProblem):
    """A window as pymoo wants it."""

    def __init__(self, oracle: Oracle) -> None:
        super().__init__(n_var=oracle.problem.d, n_obj=1, xl=0.0, xu=1.0)
        self.oracle = oracle

    def _evaluate(self, x: Array, out: dict[str, Any], *args: object, **kwargs: object) -> None:
        out['F'] = np.minimum(self.oracle.costs(x), FAILED)[:, None]


def prepare(problem: Problem) -> Solve:
    """Nothing to prepare."""
    return solve


def solve(oracle: Oracle, seed: int) -> None:
    """Run it from fresh populations until the oracle stops it."""
    attempt = seed
    while True:
        algorithm = DE(pop_size=POPULATION)
        minimize(
            Window(oracle), algorithm, ('n_gen', GENERATIONS), seed=attempt, copy_algorithm=False
        )
        attempt += 1000000
