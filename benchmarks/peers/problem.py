"""One window as every peer gets it, and the oracle that stops them at the target."""

import time
from dataclasses import dataclass

import numpy as np

from benchmarks.judge import SAME_OPTIMUM, Judge
from benchmarks.zoo import CASES, MANY_UNKNOWNS, Case, draw
from benchmarks.zoo.windows import FINER
from obs_ros import Model, Record
from obs_ros.core.typing import Array
from obs_ros.inference.objective import Objective
from obs_ros.inference.parameterisation import Unknowns
from obs_ros.integration.backends import kernels_for
from obs_ros.integration.grid import Grid


class Stopped(Exception):
    """The target is reached, or the time is over."""


@dataclass(frozen=True)
class Filtered:
    """Estimates of a filter at the end of a window: states (n,) and parameters (q,)."""

    state: Array
    parameters: Array


@dataclass(frozen=True, eq=False)
class Problem:
    """A window, its true unknowns (d,) at the start and states (n,) at the end, and its noise (r,).

    `objective` counts squares in units of the noise, and is compiled; points z (d,) lie in the unit
    box of the model's unknowns, states first.
    """

    case: Case
    record: Record
    noise: Array
    truth: Array
    end: Array
    objective: Objective

    @classmethod
    def of(cls, name: str, seed: int) -> 'Problem':
        """Return the window of that seed."""
        case = case_of(name)
        drawn = draw(case, seed)
        truth = np.array(list(drawn.truth.values()))
        noise = np.array(list(drawn.noise.values()))
        kernels = kernels_for(case.model)
        grid = Grid.of(case.model, drawn.record, noise)
        objective = Objective(kernels, grid, Unknowns.of(case.model))
        fine = grid_in_steps(case.model, drawn.record, FINER)
        x0, p = np.split(truth[:, None], [len(case.model.states)])
        end = kernels.trajectories(fine, x0, p)[0][-1, :, 0]
        return cls(case, drawn.record, noise, truth, end, objective)

    @property
    def model(self) -> Model:
        """The plant."""
        return self.case.model

    @property
    def d(self) -> int:
        """Number of unknowns."""
        return self.objective.dimension

    @property
    def room(self) -> float:
        """Distance from the optimum that still counts as reaching it, in sigma^2."""
        return SAME_OPTIMUM * self.d

    @property
    def width(self) -> Array:
        """Widths (d,) of the box, whose scales are all linear."""
        assert not self.objective.unknowns.scale.growth.any()
        return self.objective.unknowns.scale.width

    def values(self, z: Array) -> Array:
        """Return the unknowns (d,) at a point (d,), in their units."""
        return self.objective.unknowns.scale.values(z)

    def at_end(self, z: Array) -> Filtered:
        """Return states and parameters at the end of the window of a point (d,)."""
        states, _ = self.objective.trajectory(z)
        return Filtered(states[-1], self.values(z)[len(self.model.states) :])

    def judged(self, starts: int, seed: int) -> float:
        """Return the least squares, in sigma^2, from the truth and `starts` other points."""
        names = self.objective.unknowns.names
        judge = Judge(self.model, self.record, names, {})
        truth = dict(zip(names, self.truth.tolist(), strict=True))
        # The judge weights all outputs equally; in all cases they have the same noise.
        return judge.optimum(truth, starts, seed) / float(self.noise[0]) ** 2


def case_of(name: str) -> Case:
    """Return the kind of windows of this name."""
    return {**CASES, **MANY_UNKNOWNS}[name]


def grid_in_steps(model: Model, record: Record, finer: int) -> Grid:
    """Return the record's grid with `finer` times as many integration steps."""
    grid = Grid.of(model, record, np.ones(len(model.outputs)))
    grid.steps[:] *= finer
    return grid


class Oracle:
    """Costs of points, in sigma^2; keeps the best, and stops whoever asks at the target.

    Also when `cap` seconds of process time are spent.
    """

    def __init__(self, problem: Problem, target: float, cap: float) -> None:
        self.problem = problem
        self.target = target
        self.best = np.full(problem.d, 0.5)
        self.least = np.inf
        self.cap = cap
        self.start()

    def start(self) -> None:
        """Start the clock."""
        self._end = time.process_time() + self.cap

    @property
    def reached(self) -> bool:
        """True once the best point is good enough."""
        return self.least <= self.target

    def costs(self, z: Array) -> Array:
        """Return the costs (B,) of points (B, d); raises Stopped."""
        cost = self.note(z)
        self.check()
        return cost

    def note(self, z: Array) -> Array:
        """Return the costs (B,) of points (B, d), without stopping."""
        cost = self.problem.objective.costs(z)
        i = int(np.argmin(cost))
        if cost[i] < self.least:
            self.best, self.least = np.array(z[i]), float(cost[i])
        return cost

    def check(self) -> None:
        """Raise Stopped when the target is reached or the time is over."""
        if self.reached or time.process_time() > self._end:
            raise Stopped
