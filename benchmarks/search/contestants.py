"""Searches that the default one is compared with, behind the same front door.

`direct` is the default search without its growing horizon: the rounds, the local search, the rules
of acceptance are the product's own, only its starts come straight from the whole window. `scipy` is
one start of scipy's least squares on the compiled residual. Importing this module registers both.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import least_squares

from benchmarks.judge import finite
from obs_ros.core.typing import Array
from obs_ros.inference.objective import Objective
from obs_ros.optimization.acceptance import Acceptance
from obs_ros.optimization.initial_population import first_population
from obs_ros.optimization.memetic import MemeticSettings, Rounds
from obs_ros.optimization.methods import Method
from obs_ros.optimization.result import Effort, Found


class DirectRounds(Rounds):
    """Rounds that start on the whole window, evolved there if there are generations at all."""

    def _first_candidates(self, number: int) -> Array:
        settings, objective = self.settings, self.objective
        z = first_population(
            settings.chaos, settings.population, objective.dimension, self.rng, even=True
        )
        if settings.generations > 0:
            unevolved = z[self.rng.permutation(len(z))[: settings.unevolved]]
            z = np.vstack([self._evolve(z, objective.nodes), unevolved])
        if not self.deadline.never:
            self._remember(z, objective.costs(z))  # whatever happens later, there is an answer
        return z


def direct_search(*task: Any) -> Found:
    """Search like `memetic_search`, of the same arguments, but without its prefixes."""
    search = DirectRounds(*task)
    for number in range(search.settings.max_rounds):
        search.run(number)
        if search.accepted or search.deadline.passed:
            break
    return search.found()


@dataclass(frozen=True)
class ScipySettings:
    """Of scipy's trust region, everything is its default but the scaling by the Jacobian."""


def scipy_search(objective: Objective, rng: np.random.Generator, *_: Any) -> Found:
    """Run scipy's least squares, with differences of its own, from one random point to its end."""

    def residuals(z: Array) -> Array:
        return finite(objective.residuals(z)[objective.grid.weight > 0.0])

    found = least_squares(residuals, rng.random(objective.dimension), bounds=(0, 1), x_scale='jac')
    return Found(
        z=found.x,
        cost=2.0 * float(found.cost),
        converged=bool(found.success),
        accepted=Acceptance.METHOD if found.success else None,
        effort=Effort(1, 'start'),
    )


CONTESTANTS = {
    'direct': Method(direct_search, MemeticSettings, needs_squares=True),
    'scipy': Method(scipy_search, ScipySettings, needs_squares=True),
}
