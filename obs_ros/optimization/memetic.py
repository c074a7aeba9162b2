"""The default search: differential evolution, then least squares over a growing horizon.

Chaotic differential evolution on a short prefix of the window, its best and some un-evolved
candidates taken by Levenberg-Marquardt over a horizon that grows to the whole window; in rounds
until an acceptance rule holds. Differential evolution gives the diversity of the start; measured,
the growing horizon does the work.
"""

from dataclasses import dataclass, field
from functools import partial

import numpy as np

from obs_ros.core.deadline import Deadline
from obs_ros.core.typing import Array
from obs_ros.optimization.acceptance import (
    Acceptance,
    acceptance_with_noise,
    acceptance_without_noise,
)
from obs_ros.optimization.differential_evolution import (
    DifferentialEvolution,
    Strategy,
    check_count,
    check_settings,
)
from obs_ros.optimization.growing_horizon import (
    HORIZON_DEFAULTS,
    HorizonSettings,
    first_prefix,
    grown,
)
from obs_ros.optimization.initial_population import (
    check_population,
    costs_in_time,
    first_population,
)
from obs_ros.optimization.levenberg_marquardt import (
    LM_DEFAULTS,
    LMSettings,
    Starts,
    Trail,
    levenberg_marquardt,
    optimum_width,
)
from obs_ros.optimization.problem import Problem
from obs_ros.optimization.result import Effort, Found


@dataclass(frozen=True)
class MemeticSettings:
    """Settings of the differential evolution at the start, and when to stop.

    With unknown noise, `fast` accepts when two survivors of one round agree and the residual is
    white, `safe` when the best of two rounds do.
    """

    chaos: str = 'cubic'
    population: int = 32
    generations: int = 5
    strategy: Strategy = 'best/1/bin'
    differential_weight: float = 0.5
    crossover: float = 0.9
    acceptance: str = 'fast'
    max_rounds: int = 8
    elite: int = 4  # evolved candidates handed on
    unevolved: int = 4  # handed on as they were drawn: they find what the evolution left
    short_window: int = 100  # nodes; below, there is no prefix worth a search of its own
    full_iterations: int = 120  # rollouts over the whole window, in each round
    direct_iterations: int = 2  # that every start should get before a short deadline
    round_rollouts: int = 30  # of a population over the window, which a round costs roughly
    patience: int = 8  # rollouts in which a window that does not fit must come nearer
    plateau: float = 0.01  # of squares far above noise, within which two rounds agree
    negligible: float = 1e-6  # of the signal, root mean square: what is left is rounding
    horizon: HorizonSettings = HORIZON_DEFAULTS
    local: LMSettings = LM_DEFAULTS

    def __post_init__(self) -> None:
        check_population(self.chaos)
        check_settings(self.population, self.strategy, self.differential_weight, self.crossover)
        for name in ('generations', 'unevolved', 'short_window', 'round_rollouts'):
            check_count(name, getattr(self, name), 0)
        for name in ('max_rounds', 'elite', 'full_iterations', 'direct_iterations', 'patience'):
            check_count(name, getattr(self, name), 1)
        if self.acceptance not in ('fast', 'safe'):
            raise ValueError(f"acceptance {self.acceptance!r} is neither 'fast' nor 'safe'")


def memetic_search(
    objective: Problem,
    rng: np.random.Generator,
    deadline: Deadline,
    settings: MemeticSettings,
    warm: Array | None = None,
    noise_known: bool = False,
) -> Found:
    """Search the optimum of a window; `warm` (d,) is a start beside fresh ones.

    Residuals have unit variance when `noise_known`. Returns the best point ever seen over the whole
    window; at least one population is rolled out over it, however early the deadline.
    """
    search = Rounds(objective, rng, deadline, settings, warm, noise_known)
    for number in range(settings.max_rounds):
        search.run(number)
        if search.accepted or deadline.passed:
            break
    return search.found()


@dataclass
class Rounds:
    """One search, with the best that its rounds have found so far."""

    objective: Problem
    rng: np.random.Generator
    deadline: Deadline
    settings: MemeticSettings
    warm: Array | None
    noise_known: bool
    accepted: Acceptance | None = None
    converged: bool = False
    best: Array = field(init=False)
    squares: float = np.inf
    bests: list[float] = field(default_factory=list)
    rounds: int = 0

    def __post_init__(self) -> None:
        self.best = np.full(self.objective.dimension, 0.5)

    def run(self, number: int) -> None:
        """Run one round from a fresh population."""
        settings = self.settings
        candidates = self._first_candidates(number)
        self.rounds += 1
        if self.deadline.passed:
            return
        # Half of them: where the data say little, two may well agree on a false minimum.
        enough = partial(self._enough, max(2, len(candidates) // 2))
        hopeless = partial(self._stuck, Trail(settings.patience))
        last = levenberg_marquardt(
            self.objective, candidates, self.objective.nodes, settings.full_iterations,
            self.deadline, enough, hopeless, settings.local,
        )  # fmt: skip
        self._remember(last.z, last.squares)
        self.bests.append(float(last.squares[0]))
        if self.squares == last.squares[0]:
            self.converged = bool(last.converged[0])
        self._judge(last)

    def found(self) -> Found:
        """Return what was found."""
        return Found(
            z=self.best,
            cost=self.squares,
            converged=self.converged,
            accepted=self.accepted,
            effort=Effort(self.rounds, 'round'),
        )

    def _first_candidates(self, number: int) -> Array:
        """Return starts (P, d) for the whole window."""
        settings, nodes = self.settings, self.objective.nodes
        z = first_population(
            settings.chaos, settings.population, self.objective.dimension, self.rng, even=True,
            deadline=self.deadline,
        )  # fmt: skip
        unevolved = z[self.rng.permutation(len(z))[: settings.unevolved]]
        if self.warm is not None:
            z[-1] = self.warm
            unevolved = np.vstack([unevolved, self.warm])
        if nodes <= settings.short_window or not self.deadline.never:
            # Whatever happens later, there is an answer; and its time foretells that of a round.
            begin = self.deadline.elapsed
            costs = costs_in_time(self.objective, z, self.deadline)
            self._remember(z, costs)
            spent, left = self.deadline.elapsed - begin, self.deadline.remaining
            if nodes <= settings.short_window or left < settings.round_rollouts * spent:
                starts = np.vstack([z[np.argsort(costs)[: settings.elite]], unevolved])
                # Few starts that get somewhere are better than many that do not.
                iteration = spent / len(z) * (1 + self.objective.dimension)  # of one start
                affordable = left / (settings.direct_iterations * max(iteration, 1e-9))
                return starts[: max(1, int(min(affordable, len(starts))))]
        prefix = first_prefix(self.objective, number, settings.horizon)
        starts = np.vstack([self._evolve(z, prefix), unevolved])
        return grown(
            self.objective, starts, prefix, self.deadline, self._remember, settings.horizon,
            settings.local,
        )  # fmt: skip

    def _evolve(self, z: Array, nodes: int) -> Array:
        settings = self.settings
        evolution = DifferentialEvolution(
            z, self.rng, settings.strategy, settings.differential_weight, settings.crossover
        )
        for _ in range(settings.generations + 1):
            if self.deadline.passed:
                break
            trials = evolution.ask(self.deadline)
            evolution.tell(costs_in_time(self.objective, trials, self.deadline, nodes))
        return evolution.population[np.argsort(evolution.costs)[: settings.elite]]

    def _enough(self, quorum: int, stopped: Starts) -> bool:
        """Whether so many have converged to one optimum that the others may stop."""
        best = stopped.squares[0]
        if not stopped.converged[0] or best > self.squares:
            return False
        return stopped.agreeing(best, self._width(best)) >= quorum

    def _stuck(self, trail: Trail, squares: float) -> bool:
        """Whether the least squares are far above noise and hardly fall any more."""
        gain = trail.gain(squares)
        return self._is_far(squares) and gain < self._width(squares)

    def _is_far(self, squares: float) -> bool:
        """Whether squares are far above noise, in units that may be but a guess of it."""
        return squares > self.settings.horizon.bad_noise * self._freedom

    def _width(self, squares: float) -> float:
        """Return how far apart squares of one and the same optimum may be."""
        return optimum_width(self.objective, squares, self.settings.local)

    @property
    def _freedom(self) -> int:
        return max(1, self.objective.count(self.objective.nodes) - self.objective.dimension)

    def _remember(self, z: Array, squares: Array) -> None:
        i = int(np.argmin(squares))
        if squares[i] < self.squares:
            self.best, self.squares = z[i].copy(), float(squares[i])

    def _judge(self, last: Starts) -> None:
        """Decide whether the best point can be believed to be the optimum, and by which rule."""
        if not np.isfinite(self.squares):
            return
        same = self._width(self.squares)
        above = np.array(self.bests) - self.squares
        rounds = int(np.count_nonzero(above <= same))
        # What no candidate fits has flat valleys: more rounds would tell nothing new.
        flat = int(np.count_nonzero(above <= max(same, self.settings.plateau * self.squares)))
        if self.noise_known:
            self.accepted = acceptance_with_noise(
                self.squares,
                self._freedom,
                converged=self.converged,
                rounds=flat if self._is_far(self.squares) else rounds,
            )
            return
        fast = self.settings.acceptance == 'fast'
        self.accepted = acceptance_without_noise(
            self.objective,
            self.best,
            self.squares,
            rounds=rounds,
            flat=flat,
            survivors=last.agreeing(self.squares, same) if fast else 0,
            negligible=self.settings.negligible,
        )
