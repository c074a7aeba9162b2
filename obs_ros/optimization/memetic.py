"""The default search: differential evolution, then least squares over a growing horizon.

Chaotic differential evolution on a short prefix of the window, its best and some un-evolved
candidates taken by Levenberg-Marquardt over a horizon that grows to the whole window; in rounds
until an acceptance rule holds.

Differential evolution gives the diversity of the start; measured, the growing horizon does the
work: on a short prefix even a chaotic plant has few false minima, and what fits it well leads on.
"""

from dataclasses import dataclass, field
from functools import partial

import numpy as np

from obs_ros.core.deadline import Deadline
from obs_ros.core.residual_tests import is_white, like_noise
from obs_ros.core.typing import Array, IntArray
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
from obs_ros.optimization.levenberg_marquardt import Starts, Trail, levenberg_marquardt
from obs_ros.optimization.problem import Problem
from obs_ros.optimization.result import Acceptance, Effort, Found

ELITE = 4  # evolved candidates handed on
UNEVOLVED = 4  # candidates handed on as they were drawn: they find what the evolution left
SHORT_WINDOW = 100  # nodes; below, there is no prefix worth a search of its own
PREFIX_SHARES = (16, 8, 32, 4)  # of the window, by round
SMALLEST_PREFIX = 16  # nodes
PREFIXES = 48  # numbers of nodes at which a growing horizon may end
# A horizon that no candidate leads on is given up: after so many steps in a row by one prefix each,
# and after so many steps at all (windows of the zoo that fit need 5 at most).
CRAWLING, MOST_STEPS = 2, 6
BAD_SHARE, BAD_NOISE = 0.01, 4.0  # of the signal's and of the noise's mean square
PREFIX_ITERATIONS, FULL_ITERATIONS = 12, 120
PATIENCE = 8  # rollouts in which a window that does not fit must come nearer
DIRECT_ITERATIONS = 2  # at least, that every start should get before a short deadline
ROUND_ROLLOUTS = 30  # rollouts of a population over the window that a round costs, roughly
# Two costs are the same optimum when they differ by less than this times d times the noise
# variance: 0.41 for four unknowns.
SAME_OPTIMUM = 0.1025
NEGLIGIBLE = 1e-6  # of the signal, root mean square


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

    def __post_init__(self) -> None:
        check_population(self.chaos)
        check_settings(self.population, self.strategy, self.differential_weight, self.crossover)
        check_count('generations', self.generations, 0)
        if self.acceptance not in ('fast', 'safe'):
            raise ValueError(f"acceptance {self.acceptance!r} is neither 'fast' nor 'safe'")
        check_count('max_rounds', self.max_rounds, 1)


def memetic_search(
    objective: Problem,
    rng: np.random.Generator,
    deadline: Deadline,
    settings: MemeticSettings,
    warm: Array | None = None,
    noise_known: bool = False,
) -> Found:
    """Search the optimum of a window; `warm` (d,) is a start to race against fresh ones.

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
    """One search: what its rounds have found so far."""

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
        nodes = self.objective.nodes
        candidates = self._first_candidates(number)
        self.rounds += 1
        if self.deadline.passed:
            return
        # Half of them: where the data tell little, two may well agree on a false minimum.
        enough = partial(self._enough, max(2, len(candidates) // 2))
        last = levenberg_marquardt(
            self.objective,
            candidates,
            nodes,
            FULL_ITERATIONS,
            self.deadline,
            enough,
            partial(self._stuck, Trail(PATIENCE)),
        )
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
            settings.chaos,
            settings.population,
            self.objective.dimension,
            self.rng,
            even=True,
            deadline=self.deadline,
        )
        unevolved = z[self.rng.permutation(len(z))[:UNEVOLVED]]
        if self.warm is not None:
            z[-1] = self.warm
            unevolved = np.vstack([unevolved, self.warm])
        if nodes <= SHORT_WINDOW or not self.deadline.never:
            # Whatever happens later, there is an answer; and it tells what a round will take.
            begin = self.deadline.elapsed
            costs = costs_in_time(self.objective, z, self.deadline)
            self._remember(z, costs)
            spent, left = self.deadline.elapsed - begin, self.deadline.remaining
            if nodes <= SHORT_WINDOW or left < ROUND_ROLLOUTS * spent:
                starts = np.vstack([z[np.argsort(costs)[:ELITE]], unevolved])
                # Few starts that get somewhere are better than many that do not.
                iteration = spent / len(z) * (1 + self.objective.dimension)  # of one start
                affordable = left / (DIRECT_ITERATIONS * max(iteration, 1e-9))
                return starts[: max(1, int(min(affordable, len(starts))))]
        prefix = self._prefix(number)
        evolved = self._evolve(z, prefix)
        return self._grow(np.vstack([evolved, unevolved]), prefix)

    def _prefix(self, number: int) -> int:
        """Nodes of the first horizon: a share of the window that still tells something."""
        nodes, d = self.objective.nodes, self.objective.dimension
        prefix = max(nodes // PREFIX_SHARES[number % len(PREFIX_SHARES)], SMALLEST_PREFIX)
        while prefix < nodes and self.objective.count(prefix) < 4 * d:
            prefix *= 2
        return min(prefix, nodes)

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
        return evolution.population[np.argsort(evolution.costs)[:ELITE]]

    def _grow(self, z: Array, nodes: int) -> Array:
        """Polish over a horizon that grows as far as the best candidate stays near the data.

        Where no candidate does, as in a window that the model cannot explain, the whole window is
        all that is left.
        """
        total = self.objective.nodes
        prefixes = np.unique(np.geomspace(nodes, total, PREFIXES).round().astype(np.int64))
        counts = np.diff([0, *(self.objective.count(int(prefix)) for prefix in prefixes)])
        steps = crawled = 0
        while nodes < total and steps < MOST_STEPS and crawled < CRAWLING:
            if self.deadline.passed:
                break
            starts = levenberg_marquardt(self.objective, z, nodes, PREFIX_ITERATIONS, self.deadline)
            z = starts.z[: max(2, len(z) // 2)]
            blocks = self.objective.block_squares(z, prefixes)
            self._remember(z, blocks.sum(axis=0))
            variance = starts.squares[0] / max(1, self.objective.count(nodes) - z.shape[1])
            reach = self._reach(blocks, counts, variance)
            beyond, reached = int(prefixes[prefixes > nodes][0]), int(prefixes[reach.max()])
            steps += 1
            crawled = crawled + 1 if reached <= beyond else 0
            nodes = max(beyond, reached)
            z = z[np.argsort(blocks[: np.searchsorted(prefixes, nodes) + 1].sum(axis=0))]
        return z

    def _reach(self, blocks: Array, counts: IntArray, variance: float) -> IntArray:
        """Return for every candidate the first block (B,) that it misses; the last if none.

        blocks (G, B) are squares, counts (G,) the numbers of residuals in them.
        """
        limit = BAD_SHARE * self.objective.signal + BAD_NOISE * variance
        bad = ~(blocks < limit * np.maximum(counts, 1)[:, None])
        bad[-1] = True
        return np.asarray(bad.argmax(axis=0))

    def _enough(self, quorum: int, stopped: Starts) -> bool:
        """Whether so many have converged to one optimum that the others may stop."""
        best = stopped.squares[0]
        if not stopped.converged[0] or best > self.squares:
            return False
        return self._agreeing(stopped, best) >= quorum

    def _stuck(self, trail: Trail, squares: float) -> bool:
        """Whether the least squares are far above noise and hardly fall any more."""
        gain = trail.gain(squares)
        return squares > BAD_NOISE * self._freedom and gain < self._same(squares)

    def _agreeing(self, starts: Starts, best: float) -> int:
        """Count the converged starts whose squares are the best ones."""
        return int(np.count_nonzero(starts.converged & (starts.squares - best <= self._same(best))))

    def _same(self, squares: float) -> float:
        """Return how far apart squares of one and the same optimum may be."""
        variance = max(squares, self.objective.floor(self.objective.nodes)) / self._freedom
        return SAME_OPTIMUM * self.objective.dimension * variance

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
        nodes = self.objective.nodes
        same = self._same(self.squares)
        agreeing = np.count_nonzero(np.array(self.bests) - self.squares <= same)
        if self.noise_known:
            if self.converged and like_noise(self.squares, self._freedom):
                self.accepted = Acceptance.LIKE_NOISE
            elif agreeing >= 2:
                self.accepted = Acceptance.ROUNDS
            return
        fast = self.settings.acceptance == 'fast' and self._agreeing(last, self.squares) >= 2
        if not fast and agreeing < 2:
            return
        # A residual too small to matter is not asked for its colour: rounding is not white.
        negligible = NEGLIGIBLE**2 * self.objective.signal * self.objective.count(nodes)
        if self.squares <= negligible or is_white(self.objective.residuals(self.best)):
            self.accepted = Acceptance.WHITE_SURVIVORS if fast else Acceptance.WHITE_ROUNDS
        elif agreeing >= 2:
            # More rounds would find it again: what is left is no fault of the search.
            self.accepted = Acceptance.ROUNDS
