"""One random window of the zoo, solved in every way and judged."""

import functools
import time
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from scipy.special import chdtri

from benchmarks.judge import FINER, SAME_OPTIMUM, Judge, values_of
from benchmarks.runner import timed
from benchmarks.search.contestants import CONTESTANTS
from benchmarks.zoo import CASES, Case, Drawn, draw
from obs_ros import Estimate, Outcome
from obs_ros.core.deadline import Deadline
from obs_ros.core.model import names
from obs_ros.core.residual_tests import LIMITS
from obs_ros.horizon.settings import EstimationSettings
from obs_ros.horizon.solver import Solver
from obs_ros.optimization.memetic import MemeticSettings

DEADLINES = (0.005, 0.02, 0.1)  # s
# A search must not draw the numbers that made its window (a plain seed draws those).
SEARCH_STREAM, JUDGE_STREAM = 2, 3


class Way(NamedTuple):
    """A search and its options; it may know the noise, and be given so many s of process time."""

    search: str
    options: Mapping[str, Any] = {}
    noise_known: bool = False
    seconds: float | None = None


_DE = Way('direct')
_LATIN = Way('direct', {'chaos': 'latin_hypercube', 'population': 8, 'generations': 0})
RIVALS = {'memetic': Way('memetic'), 'DE + LM': _DE, 'Latin hypercube + LM': _LATIN}
KNOWN, SAFE, CHI_SQUARE = 'memetic, noise known', 'memetic, safe', 'chi-square alone'
WAYS = {
    'memetic': RIVALS['memetic'],
    KNOWN: Way('memetic', noise_known=True),
    'DE + LM': _DE,
    'Latin hypercube + LM': _LATIN,
    'paper mode': Way('chaotic_de'),
    'scipy, 1 start': Way('scipy'),
}


class Score(NamedTuple):
    """The result of one way on a window.

    `excess` of the squares over the optimum, in shares of what still counts as the optimum; process
    time in s; whether the search believed its result, and whether it said so without a caveat.
    """

    excess: float
    seconds: float
    accepted: bool
    converged: bool

    @property
    def solved(self) -> bool:
        """True for the optimum."""
        return self.excess <= 1.0


class Verdict(NamedTuple):
    """All scores of a window, by way; and by how much the best of them beat the judge, likewise."""

    scores: Mapping[str, Score]
    judge_excess: float


Verdicts = Mapping[str, Sequence[Verdict]]  # by case, over the seeds


class ProcessDeadline(Deadline):
    """A deadline in process time: searches that share a core still get the same time each."""

    def __init__(self, seconds: float) -> None:
        super().__init__(seconds)

    @staticmethod
    def _now() -> float:
        return time.process_time()


def all_ways() -> Mapping[str, Way]:
    """Return every way by name: to the end, by rule of acceptance, by deadline."""
    limited = {
        limited_name(name, seconds): way._replace(seconds=seconds)
        for name, way in RIVALS.items()
        for seconds in DEADLINES
    }
    return {**WAYS, SAFE: Way('memetic', {'acceptance': 'safe'}), **limited}


def limited_name(name: str, seconds: float) -> str:
    """Name a way that has so many s."""
    return f'{name}, {1e3 * seconds:g} ms'


def contested(name: str, seed: int, near: int = 3, far: int = 6) -> Verdict:
    """Solve one window in every way, and judge: from starts about the truth and anywhere."""
    case = CASES[name]
    warm_up(name)
    window = draw(case, seed)
    found = {name: solved(case, window, way, seed) for name, way in all_ways().items()}
    found[CHI_SQUARE] = by_chi_square(case, window, seed)
    noise = np.array(list(window.noise.values()))
    judge = Judge(case.model, window.record, names(case.model.variables), {}, noise, FINER)
    squares = {name: judged_squares(judge, estimate) for name, (estimate, _) in found.items()}
    judged = judge.optimum(window.truth, far, [seed, JUDGE_STREAM], near)
    optimum = min(judged, *squares.values())
    unit = SAME_OPTIMUM * len(case.model.variables)
    scores = {
        name: Score(
            excess=(squares[name] - optimum) / unit,
            seconds=seconds,
            accepted=estimate.outcome not in (Outcome.DEADLINE, Outcome.DIVERGED),
            converged=estimate.outcome in (Outcome.CONVERGED, Outcome.AT_BOUND),
        )
        for name, (estimate, seconds) in found.items()
    }
    return Verdict(scores, (judged - optimum) / unit)


@functools.cache
def warm_up(name: str) -> None:
    """Touch, once in every process, all that a first solve of a case touches."""
    window = draw(CASES[name], 0)
    for way in all_ways().values():
        solved(CASES[name], window, way._replace(seconds=0.02), 0)


def solved(case: Case, window: Drawn, way: Way, seed: int) -> tuple[Estimate, float]:
    """Solve; return the estimate and the process time in s of all but the drawing."""

    def call() -> Estimate:
        settings = EstimationSettings(
            search=CONTESTANTS.get(way.search, way.search),
            search_options=way.options,
            noise=window.noise if way.noise_known else None,
        )
        solver = Solver.of(case.model, settings)
        limit = Deadline() if way.seconds is None else ProcessDeadline(way.seconds)
        return solver.solve(window.record, np.random.default_rng([seed, SEARCH_STREAM]), limit)

    return timed(call)


def by_chi_square(case: Case, window: Drawn, seed: int) -> tuple[Estimate, float]:
    """Believe the first round that fits as well as the noise allows, converged or not.

    The product has no such rule: its search with known noise is given one round more at a time.
    """
    freedom = np.count_nonzero(np.isfinite(window.record.y)) - len(case.model.variables)
    limit = float(chdtri(freedom, LIMITS.tail))
    for rounds in range(1, MemeticSettings().max_rounds + 1):
        way = Way('memetic', {'max_rounds': rounds}, noise_known=True)
        estimate, seconds = solved(case, window, way, seed)
        if 2.0 * estimate.cost <= limit:
            return estimate, seconds
    return estimate, seconds


def judged_squares(judge: Judge, estimate: Estimate) -> float:
    """Return the squares of an estimate in the judge's eyes."""
    return judge.squares(values_of(estimate)) if estimate.usable else np.inf
