"""scipy's differential evolution with its defaults, its polishing included, again and again.

The objective is that of a user without a compiler: `solve_ivp` for one candidate, or the whole
population at once through NumPy.
"""

from collections.abc import Callable

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import differential_evolution

from benchmarks.peers.problem import Oracle, Problem
from benchmarks.peers.registry import Solve
from obs_ros.core.typing import Array
from obs_ros.inference.objective import Objective
from obs_ros.integration.backends import kernels_for

RELATIVE, ABSOLUTE = 1e-6, 1e-8
FAILED = 1e12


def with_solve_ivp(problem: Problem) -> Solve:
    """Integrate candidates one by one with scipy's RK45, whose steps adapt."""

    def solve(oracle: Oracle, seed: int) -> None:
        def cost(z: Array) -> float:
            squares = np.sum(integrated_residuals(oracle.problem, z) ** 2)
            return told(oracle, z[None], np.array([squares]))[0]

        evolve(cost, oracle.problem.d, seed)

    return solve


def vectorised(problem: Problem) -> Solve:
    """Integrate the whole population with RK4 on NumPy arrays."""
    kernels = kernels_for(problem.model, 'numpy')

    def solve(oracle: Oracle, seed: int) -> None:
        ours = oracle.problem.objective
        slow = Objective(kernels, ours.grid, ours.unknowns)

        def costs(z: Array) -> Array:
            points = np.atleast_2d(z.T)  # the polishing asks for single points
            found = told(oracle, points, slow.costs(points))
            return found if z.ndim == 2 else found[0]

        evolve(costs, oracle.problem.d, seed, vectorized=True, updating='deferred')

    return solve


def evolve(cost: Callable[..., object], d: int, seed: int, **settings: object) -> None:
    """Run it from fresh populations until the oracle stops it."""
    rng = np.random.default_rng(seed)
    while True:
        differential_evolution(cost, [(0.0, 1.0)] * d, rng=rng, maxiter=10000, **settings)


def told(oracle: Oracle, z: Array, costs: Array) -> Array:
    """Tell the oracle of points that are better than all before; return costs that are finite."""
    i = int(np.argmin(costs))
    if costs[i] < oracle.least:
        oracle.note(z[i][None])
    oracle.check()
    return np.minimum(np.nan_to_num(costs, nan=FAILED), FAILED)


def integrated_residuals(problem: Problem, z: Array) -> Array:
    """Return residuals (K, r) of one point, in units of the noise; the inputs are steady."""
    model, record = problem.model, problem.record
    n = len(model.states)
    values = problem.values(z)
    u, p = tuple(record.u[0]), tuple(values[n:])
    found = solve_ivp(
        lambda t, x: model.dynamics(t, x, u, p),
        (record.t[0], record.t[-1]),
        values[:n],
        t_eval=record.t,
        rtol=RELATIVE,
        atol=ABSOLUTE,
    )
    if not found.success:
        return np.full(record.y.shape, np.inf)
    outputs = np.stack(model.output(record.t, tuple(found.y), u, p), axis=1)
    return (outputs - record.y) / problem.noise
