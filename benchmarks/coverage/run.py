"""Windows solved alone and in sequence: what is published of them, beside the truth."""

from collections.abc import Sequence
from functools import partial
from typing import NamedTuple

import numpy as np

from benchmarks.intervals import published_interval
from benchmarks.judge import Judge
from benchmarks.runner import timed
from benchmarks.zoo.experiments import EXPERIMENTS, Drawn, Experiment, run
from obs_ros import Estimate, solve_window
from obs_ros.core.deadline import Deadline
from obs_ros.core.model import names
from obs_ros.core.rng import random_generator
from obs_ros.core.typing import Array, BoolArray
from obs_ros.horizon.moving_horizon import MovingHorizon
from obs_ros.horizon.settings import EstimationSettings
from obs_ros.horizon.solver import Solver

IN_RUN = 10  # windows of a run, in sequence
KINDS = {True: 'rich', False: 'poor'}
WAYS = {False: 'alone', True: 'in sequence'}
FAR = 5.0  # standard deviations


class Track(NamedTuple):
    """The windows W of one run: parameters (W, q), then end states (W, n), in their units.

    What is withheld is NaN. Of `parameters` there are q; `jumps` (W,) are those announced anew;
    `squares` (W,) of the residuals, in the noise's variance, are those of the initial state and
    the parameters published.
    """

    error: Array
    sd: Array
    lower: Array
    upper: Array
    truth: Array
    parameters: int
    outcomes: tuple[str, ...]
    jumps: tuple[int, ...]
    squares: Array

    def part(self, states: bool) -> slice:
        """Return the places of end states, or of parameters."""
        return slice(self.parameters, None) if states else slice(0, self.parameters)

    @property
    def given(self) -> BoolArray:
        """Values (W, q + n) with a published interval."""
        return np.asarray(np.isfinite(self.lower) & np.isfinite(self.upper))

    @property
    def held(self) -> BoolArray:
        """Values (W, q + n) whose published interval holds the truth."""
        return np.asarray((self.lower <= self.truth) & (self.truth <= self.upper))

    @property
    def far(self) -> BoolArray:
        """Values (W, q + n) more than FAR published deviations off."""
        return np.asarray(np.abs(self.error) > FAR * self.sd)


def noise_of(experiment: Experiment) -> dict[str, float]:
    """Return the standard deviations by output."""
    return dict(zip(names(experiment.model.outputs), experiment.noise, strict=True))


def likelihood_of(experiment: Experiment, drawn: Drawn) -> Judge:
    """Return the squares of a window's residuals in the noise's variance, of all unknowns."""
    known = names(experiment.model.variables)
    return Judge(experiment.model, drawn.record, known, {}, np.array(experiment.noise))


def tracked(name: str, rich: bool, sequence: bool, seed: int) -> Track:
    """Solve a window alone, or a run of windows in sequence, and put the truth beside them."""
    experiment = EXPERIMENTS[name]
    drawn = run(experiment, seed, rich, IN_RUN if sequence else 1)
    solve = in_sequence if sequence else alone
    return beside_truth(experiment, drawn, solve(experiment, drawn, seed))


def alone(experiment: Experiment, drawn: Drawn, seed: int) -> list[Estimate]:
    """Return the estimate of a window."""
    noise = noise_of(experiment)
    return [solve_window(experiment.model, drawn.record, noise=noise, seed=seed)]


def in_sequence(experiment: Experiment, drawn: Drawn, seed: int) -> list[Estimate]:
    """Return the estimates of the windows of a run, which abut."""
    return [estimate for estimate, _ in timed_sequence(experiment, drawn, seed)]


def timed_sequence(experiment: Experiment, drawn: Drawn, seed: int) -> list[tuple[Estimate, float]]:
    """Return the estimates of the windows of a run with their process times (s)."""
    solver = Solver.of(experiment.model, EstimationSettings(noise=noise_of(experiment)))
    solver.prepare()
    horizon = MovingHorizon(solver)
    records = [
        drawn.window(first, experiment.samples).record
        for first in range(0, drawn.record.t.size, experiment.samples)
    ]
    return [
        timed(partial(horizon.solve, record, random_generator(seed, i), Deadline()))
        for i, record in enumerate(records)
    ]


def beside_truth(experiment: Experiment, drawn: Drawn, estimates: Sequence[Estimate]) -> Track:
    """Return the estimates of the windows of a run with its truth."""
    parameters = names(experiment.model.parameters)
    known = (*parameters, *names(experiment.model.states))
    ends = drawn.x[experiment.samples - 1 :: experiment.samples]
    truth = np.hstack([np.tile(drawn.p, (len(ends), 1)), ends])
    values = np.array([[values_of(estimate)[v] for v in known] for estimate in estimates])
    intervals = np.array(
        [[published_interval(estimate, v) for v in known] for estimate in estimates]
    )
    starts = range(0, drawn.record.t.size, experiment.samples)
    squares = [
        likelihood_of(experiment, drawn.window(first, experiment.samples)).squares(
            {**estimate.initial_state, **estimate.parameters}
        )
        for first, estimate in zip(starts, estimates, strict=True)
    ]
    return Track(
        error=values - truth,
        sd=np.array([[estimate.stddev[v] for v in known] for estimate in estimates]),
        lower=intervals[..., 0],
        upper=intervals[..., 1],
        truth=truth,
        parameters=len(parameters),
        outcomes=tuple(estimate.outcome.value for estimate in estimates),
        jumps=tuple(sum(jump.new for jump in estimate.jumps) for estimate in estimates),
        squares=np.array(squares),
    )


def values_of(estimate: Estimate) -> dict[str, float]:
    """Return parameters and end state by name."""
    return {**estimate.parameters, **estimate.state}
