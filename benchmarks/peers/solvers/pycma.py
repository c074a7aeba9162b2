"""CMA-ES (pycma) on our compiled rollouts; its population doubles at every restart."""

import cma
import numpy as np

from benchmarks.peers.problem import Oracle, Problem
from benchmarks.peers.registry import Solve

FIRST_SPREAD = 0.3
LARGEST_POPULATION = 512
FAILED = 1e12


def prepare(problem: Problem) -> Solve:
    """Nothing to prepare."""
    return solve


def solve(oracle: Oracle, seed: int) -> None:
    """Run it, restarted from random points with larger populations, until the oracle stops it."""
    d = oracle.problem.d
    rng = np.random.default_rng(seed)
    population = 16  # a chunk of lanes; its own default is 9
    while True:
        search = cma.CMAEvolutionStrategy(
            rng.random(d),
            FIRST_SPREAD,
            {
                'bounds': [0.0, 1.0],
                'popsize': population,
                'seed': int(rng.integers(1, 2**31)),
                'verbose': -9,
            },
        )
        while not search.stop():
            points = search.ask()
            search.tell(points, np.minimum(oracle.costs(np.array(points)), FAILED).tolist())
        population = min(2 * population, LARGEST_POPULATION)
