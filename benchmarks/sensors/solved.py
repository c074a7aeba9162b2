"""Windows solved beside their truth: errors, intervals, outcomes, jumps, process time."""

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from benchmarks.intervals import published_interval
from benchmarks.runner import timed
from obs_ros import Estimate, Model, Record, solve_window
from obs_ros.core.deadline import Deadline
from obs_ros.core.rng import random_generator
from obs_ros.core.typing import Array
from obs_ros.horizon.moving_horizon import MovingHorizon
from obs_ros.horizon.settings import EstimationSettings
from obs_ros.horizon.solver import Solver

GOOD = ('converged', 'at_bound')


class Solved(NamedTuple):
    """One window: parameters (q,) in their units, outcome, message, new jumps, process time (s).

    `lower` and `upper` are the ends of published intervals; `state` (n,) is the one at the end.
    What is withheld is NaN.
    """

    values: Array
    error: Array
    sd: Array
    lower: Array
    upper: Array
    state: Array
    outcome: str
    message: str
    jumps: int
    seconds: float

    @property
    def accepted(self) -> bool:
        """Whether the outcome is good and every parameter has its deviation."""
        return self.outcome in GOOD and bool(np.isfinite(self.sd).all())

    @property
    def held(self) -> Array:
        """1 where the interval (q,) holds the truth, 0 where not, NaN where none is given."""
        truth = self.values - self.error
        inside = ((self.lower <= truth) & (truth <= self.upper)).astype(np.float64)
        return np.where(np.isfinite(self.lower) & np.isfinite(self.upper), inside, np.nan)


def alone(
    model: Model, record: Record, truth: Mapping[str, float], seed: int, **options: Any
) -> Solved:
    """Solve one window by the front door; `truth` names the parameters in their order."""
    found, seconds = timed(partial(solve_window, model, record, seed=seed, **options))
    return beside(found, truth, seconds)


def in_sequence(
    model: Model, records: Sequence[Record], truth: Mapping[str, float], seed: int, **options: Any
) -> list[Solved]:
    """Solve windows one after the other, as a node does."""
    solver = Solver.of(model, EstimationSettings(**options))
    solver.prepare()
    horizon, found = MovingHorizon(solver), []
    for i, record in enumerate(records):
        solve = partial(horizon.solve, record, random_generator(seed, i), Deadline())
        estimate, seconds = timed(solve)
        found.append(beside(estimate, truth, seconds))
    return found


def beside(found: Estimate, truth: Mapping[str, float], seconds: float) -> Solved:
    """Return an estimate beside the true parameters."""
    values = np.array([found.parameters[name] for name in truth])
    ends = np.array([published_interval(found, name) for name in truth])
    return Solved(
        values=values,
        error=values - np.array(list(truth.values())),
        sd=np.array([found.stddev[name] for name in truth]),
        lower=ends[:, 0],
        upper=ends[:, 1],
        state=np.array(list(found.state.values())),
        outcome=found.outcome.value,
        message=f'{found.message} {found.advice}'.strip(),
        jumps=sum(jump.new for jump in found.jumps),
        seconds=seconds,
    )
