"""A look about an optimum, as far as noise leaves it uncertain, for neighbours that are better.

Where a plant relaxes, a small change of the unknowns takes a jump across a sample, and the squares
fall by what that sample was off. Derivatives show nothing of it. Neighbours are drawn by the
inverse of J'J, whose ellipsoids are those of equal squares (Nocedal & Wright 2006, section 10.2),
at distances in a geometric row: what a missed sample adds says nothing of the noise.
"""

from dataclasses import dataclass, replace

import numpy as np

from obs_ros.core.deadline import Deadline
from obs_ros.core.linear_algebra import eigen
from obs_ros.core.rng import random_generator
from obs_ros.core.typing import Array
from obs_ros.optimization.acceptance import Acceptance, acceptance_with_noise
from obs_ros.optimization.levenberg_marquardt import (
    LM_DEFAULTS,
    LMSettings,
    levenberg_marquardt,
)
from obs_ros.optimization.lm_linalg import usable
from obs_ros.optimization.problem import Problem
from obs_ros.optimization.result import Found

LOCAL = LMSettings(most_step=1e-9)


@dataclass(frozen=True)
class NeighbourhoodSettings:
    """Neighbours and what becomes of them.

    - `count`: of neighbours at one look;
    - `nearest`, `farthest`: distances in deviations, by the squares that are left;
    - `widest`: deviation of a combination of unknowns, in boxes, at most;
    - `better`: share of its squares by which a neighbour has to be below the optimum: less is found
      by any local search;
    - `starts`: of the best neighbours from which a local search goes on, in so many `iterations`;
    - `looks`: at most;
    - `local`: of these searches; their differences stay within the width of a jump.
    """

    count: int = 96
    nearest: float = 0.01
    farthest: float = 3.0
    widest: float = 0.2
    better: float = 0.05
    starts: int = 4
    iterations: int = 40
    looks: int = 8
    local: LMSettings = LOCAL


NEIGHBOURHOOD = NeighbourhoodSettings()


def bettered(
    problem: Problem,
    found: Found,
    deadline: Deadline,
    settings: NeighbourhoodSettings = NEIGHBOURHOOD,
    *,
    noise_known: bool,
) -> Found:
    """Return the optimum to which better neighbours lead, and theirs; `found` if there are none.

    Where residuals have unit variance, by `noise_known`, one as small as noise is accepted.
    """
    rng, freedom = random_generator(0), problem.count(problem.nodes) - problem.dimension
    for _ in range(settings.looks):
        if deadline.passed or found.accepted is Acceptance.LIKE_NOISE:
            break
        z = neighbours(problem, found, rng, settings)
        costs = problem.costs(z)
        best = np.argsort(costs)[: settings.starts]
        if not costs[best[0]] < (1.0 - settings.better) * found.cost:
            break
        solved = levenberg_marquardt(
            problem, z[best], problem.nodes, settings.iterations, deadline,
            settings=settings.local,
        )  # fmt: skip
        cost, converged = float(solved.squares[0]), bool(solved.converged[0])
        known = noise_known and acceptance_with_noise(cost, freedom, converged=converged, rounds=0)
        found = replace(
            found, z=solved.z[0], cost=cost, converged=converged, accepted=known or found.accepted
        )
    return found


def neighbours(
    problem: Problem, found: Found, rng: np.random.Generator, settings: NeighbourhoodSettings
) -> Array:
    """Return points (count, d) about a point, within the limits."""
    d, nodes = found.z.size, problem.nodes
    steps = np.full((1, d), LM_DEFAULTS.first_step)
    squares, _, hessian = problem.linearise(found.z[None], steps, nodes)
    root = np.eye(d)
    if usable(squares[0], hessian[0]):
        variance = max(problem.floor(nodes), found.cost) / max(1, problem.count(nodes) - d)
        values, root = eigen(hessian[0] / variance)
    else:
        values = np.zeros(d)
    deviations = 1.0 / np.sqrt(np.maximum(values, settings.widest**-2))
    distances = np.geomspace(settings.nearest, settings.farthest, settings.count)
    moved = distances[:, None] * rng.standard_normal((settings.count, d)) * deviations
    return np.asarray(np.clip(found.z + moved @ root.T, *problem.limits))
