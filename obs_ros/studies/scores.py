"""Figures of runs, and of the runs of a variant, by which variants are compared."""

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from obs_ros.core.typing import Array
from obs_ros.replay.cells import median
from obs_ros.replay.history import FORECASTS
from obs_ros.studies.result import Result
from obs_ros.studies.run import ERRORS

FORECAST, HELD = (f'{ERRORS[kind]}.' for kind in FORECASTS[:2])
SCATTER = 'scatter_over_sd.'


@dataclass(frozen=True)
class Score:
    """Figures of one run; NaN where there is none.

    `skill` is that of all of its forecasts, 1 - MSE / MSE of the last value held, averaged over
    the outputs; `scatter` is that of disjoint windows over their standard deviations, by
    parameter, as the last window has it. Times are in s.
    """

    estimates: int
    outcomes: Mapping[str, int]
    every_sd: int
    jumps: int
    failed: int
    skill: float
    scatter: Mapping[str, float]
    seconds: float

    @staticmethod
    def of(result: Result) -> 'Score':
        """Return the figures of a result."""
        facts: Mapping[str, Any] = result.facts
        outcomes = Counter(result.columns['outcome'])
        return Score(
            len(result), outcomes, facts['every_sd'], facts['jumps'], facts['failed'],
            _skill(result), _scatter(result), facts['wall_time'],
        )  # fmt: skip


@dataclass(frozen=True)
class Scores:
    """The runs of one variant, by recording."""

    runs: Mapping[str, Score]

    def share(self, outcome: str) -> float:
        """Return the share of estimates with that outcome, over all recordings."""
        return self._sum(lambda score: score.outcomes.get(outcome, 0)) / max(self.estimates, 1)

    @property
    def estimates(self) -> int:
        """Number of estimates."""
        return self._sum(lambda score: score.estimates)

    @property
    def every_sd(self) -> float:
        """Share of estimates with every standard deviation."""
        return self._sum(lambda score: score.every_sd) / max(self.estimates, 1)

    @property
    def jumps(self) -> int:
        """Number of jumps announced."""
        return self._sum(lambda score: score.jumps)

    @property
    def failed(self) -> int:
        """Number of solves that raised an error."""
        return self._sum(lambda score: score.failed)

    @property
    def skill(self) -> Array:
        """Forecast skill (R,) by recording; NaN = nothing to compare."""
        return np.array([score.skill for score in self.runs.values()], dtype=np.float64)

    @property
    def seconds(self) -> float:
        """Time in s that one recording took, in the median."""
        return median(np.array([score.seconds for score in self.runs.values()]))

    def scatter(self, parameter: str) -> Array:
        """Return scatter over standard deviation (R,) of a parameter; NaN = not known."""
        return np.array([score.scatter.get(parameter, math.nan) for score in self.runs.values()])

    def better(self, other: 'Scores') -> tuple[int, int]:
        """Return on how many recordings this variant forecasts better, of how many with both."""
        shared = [
            (own.skill, other.runs[name].skill)
            for name, own in self.runs.items()
            if name in other.runs
        ]
        known = [(one, two) for one, two in shared if not (math.isnan(one) or math.isnan(two))]
        return sum(one > two for one, two in known), len(known)

    def _sum(self, count: Any) -> int:
        return sum(count(score) for score in self.runs.values())


def outcomes(scores: Sequence[Scores]) -> list[str]:
    """Return all outcomes that occur, those that occur most first."""
    counts: Counter[str] = Counter()
    for each in scores:
        for score in each.runs.values():
            counts.update(score.outcomes)
    return [outcome for outcome, _ in counts.most_common()]


def parameters(scores: Sequence[Scores]) -> list[str]:
    """Return the parameters whose scatter is known anywhere."""
    return list(
        dict.fromkeys(
            name
            for each in scores
            for score in each.runs.values()
            for name, value in score.scatter.items()
            if math.isfinite(value)
        )
    )


def _skill(result: Result) -> float:
    """Return the skill; forecasts that ran away count as infinitely wrong."""
    found = []
    for name, column in result.columns.items():
        if name.startswith(FORECAST):
            error = np.asarray(column, dtype=np.float64)
            held = np.asarray(result.columns[HELD + name.removeprefix(FORECAST)], dtype=np.float64)
            known = ~np.isnan(error) & np.isfinite(held)
            with np.errstate(all='ignore'):
                found.append(1.0 - np.sum(error[known] ** 2) / np.sum(held[known] ** 2))
    known_outputs = [skill for skill in found if not math.isnan(skill)]
    return float(np.mean(known_outputs)) if known_outputs else math.nan


def _scatter(result: Result) -> dict[str, float]:
    found = {}
    for name, column in result.columns.items():
        if name.startswith(SCATTER):
            values = np.asarray(column, dtype=np.float64)
            known = values[np.isfinite(values)]
            found[name.removeprefix(SCATTER)] = float(known[-1]) if known.size else math.nan
    return found
