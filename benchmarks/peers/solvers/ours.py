"""Our `solve_window` with its defaults: it gets no oracle, it decides itself.

All of it is compiled before, as in the node: a process that solves few windows interprets at first.
"""

import numpy as np

from benchmarks.judge import values_of
from benchmarks.peers.problem import Oracle, Problem
from benchmarks.peers.registry import Solve
from obs_ros import solve_window
from obs_ros.core.model import names
from obs_ros.horizon.settings import EstimationSettings
from obs_ros.horizon.solver import Solver


def noise_unknown(problem: Problem) -> Solve:
    """Let it find the noise out."""
    Solver.of(problem.model, EstimationSettings()).prepare()
    return lambda oracle, seed: solve(oracle, seed, None)


def noise_given(problem: Problem) -> Solve:
    """Tell it the noise."""
    noise = dict(zip(names(problem.model.outputs), problem.noise.tolist(), strict=True))
    Solver.of(problem.model, EstimationSettings(noise=noise)).prepare()
    return lambda oracle, seed: solve(oracle, seed, noise)


def solve(oracle: Oracle, seed: int, noise: dict[str, float] | None) -> None:
    """Solve one window."""
    problem = oracle.problem
    estimate = solve_window(problem.model, problem.record, seed=seed, noise=noise)
    oracle.note(problem.objective.unknowns.point(values_of(estimate))[None])
    assert np.isfinite(oracle.least)
