"""One run solved: every window's estimate, its intervals and its jumps, beside the truth."""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from benchmarks.intervals import COVERED, published_interval
from benchmarks.runner import timed
from benchmarks.sequence.jumps_elsewhere.scenes import JUMP, Run, Scene, run_of
from benchmarks.sequence.jumps_elsewhere.visible import visible
from benchmarks.sequence.plants import Change
from obs_ros import Estimate, Outcome, Record
from obs_ros.core.deadline import Deadline
from obs_ros.core.estimate import Jump
from obs_ros.core.model import names
from obs_ros.core.rng import random_generator
from obs_ros.core.typing import Array, BoolArray
from obs_ros.horizon.moving_horizon import MovingHorizon
from obs_ros.horizon.settings import EstimationSettings
from obs_ros.horizon.solver import Solver

FARTHEST = 5.0  # deviations

# The outcomes that let a reader believe the numbers that are given.
ACCEPTED = (
    Outcome.CONVERGED, Outcome.APPROXIMATE, Outcome.AT_BOUND, Outcome.NOT_IDENTIFIABLE,
)  # fmt: skip


class Said(NamedTuple):
    """A jump as one window reports it: names, time and its deviation (s), largest size (sd).

    `alternatives` are the other sets of names; `probability` is NaN where none is given.
    """

    names: frozenset[str]
    time: float
    time_sd: float
    clear: float
    alternatives: tuple[str, ...]
    new: bool
    probability: float
    retracted: bool


class Followed(NamedTuple):
    """The windows of one run (W of them), in boxes: parameters and end states (W, q + n).

    `error` is the estimate less the truth; `lower` and `upper` are the ends of the interval less
    the truth, NaN where none is given. `seconds` (W,) are process times; `spoiled` (W,) tells the
    windows with an outlier, `pushed` (W,) those that process noise explains. `visible` (W,) is that
    of the least visible jump so far, in runs in which errors are far beyond their deviations.
    """

    scene: Scene
    begin: Array
    end: Array
    error: Array
    lower: Array
    upper: Array
    accepted: BoolArray
    outcomes: tuple[str, ...]
    said: tuple[tuple[Said, ...], ...]
    drifting: tuple[tuple[str, ...], ...]
    changes: tuple[Change, ...]
    moving: str
    spoiled: BoolArray
    pushed: BoolArray
    seconds: Array
    visible: Array

    @property
    def deviations(self) -> Array:
        """Half-widths (W, q + n) of the intervals, in standard deviations' units."""
        return np.asarray((self.upper - self.lower) / (2.0 * COVERED))

    @property
    def beyond(self) -> Array:
        """Errors (W, q + n) in deviations, each by the side of its interval the truth lies on."""
        side = np.where(self.error > 0.0, self.error - self.lower, self.upper - self.error)
        # An estimate outside its own interval has no side.
        half = np.where(side > 0.0, side / COVERED, self.deviations)
        return np.asarray(np.abs(self.error) / np.maximum(half, 1e-12))


def horizon_of(scene: Scene) -> MovingHorizon:
    """Return the solver of a scene's windows, as a node has it that is given the noise."""
    experiment = scene.experiment
    outputs = names(experiment.model.outputs)
    noise = dict(zip(outputs, experiment.noise, strict=True))
    return MovingHorizon(Solver.of(experiment.model, EstimationSettings(noise=noise)))


def solved(scene: Scene, records: Sequence[Record]) -> Iterator[tuple[Estimate, float]]:
    """Yield every window's estimate, and its process time in s."""
    horizon = horizon_of(scene)
    for i, record in enumerate(records):
        rng = random_generator(scene.seed, i)
        yield timed(lambda record=record, rng=rng: horizon.solve(record, rng, Deadline(None)))


def followed(scene: Scene) -> Followed:
    """Simulate a scene, solve its windows, and put the truth beside them."""
    run = run_of(scene)
    estimates, seconds = zip(*solved(scene, run.records()), strict=True)
    found = beside_truth(run, estimates, np.array(seconds))
    far = (found.beyond > FARTHEST) & found.accepted[:, None]
    if scene.kind != JUMP or not far.any():
        return found
    return found._replace(visible=visible(run))


def beside_truth(run: Run, estimates: Sequence[Estimate], seconds: Array) -> Followed:
    """Return the estimates with their errors."""
    scene, model = run.scene, run.scene.experiment.model
    ends = scene.experiment.samples * np.arange(1, scene.windows + 1)
    truth = np.hstack([run.p[ends], run.x[ends]])
    variables = (*model.parameters, *model.states)
    width = np.array([v.upper - v.lower for v in variables])
    values = np.array([[{**e.parameters, **e.state}[v.name] for v in variables] for e in estimates])
    low, high = np.moveaxis(
        np.array([[published_interval(e, v.name) for v in variables] for e in estimates]), 2, 0
    )
    factor = np.ptp(run.p, axis=0) if not run.changes else np.zeros(run.p.shape[1])
    return Followed(
        scene=scene,
        begin=np.array([estimate.t0 for estimate in estimates]),
        end=np.array([estimate.t1 for estimate in estimates]),
        error=(values - truth) / width,
        lower=(low - truth) / width,
        upper=(high - truth) / width,
        accepted=np.array([estimate.outcome in ACCEPTED for estimate in estimates]),
        outcomes=tuple(estimate.outcome.value for estimate in estimates),
        said=tuple(tuple(map(said_of, estimate.jumps)) for estimate in estimates),
        drifting=tuple(tuple(getattr(estimate, 'drifting', ())) for estimate in estimates),
        changes=run.changes,
        moving=model.parameters[int(factor.argmax())].name if factor.any() else '',
        spoiled=run.spoiled[1:].reshape(scene.windows, -1).any(axis=1),
        pushed=np.array([any(walk > 0.0 for walk in e.walks.values()) for e in estimates]),
        seconds=seconds,
        visible=np.full(scene.windows, np.inf),
    )


def said_of(jump: Jump) -> Said:
    """Return what a window says of a jump."""
    sizes = [
        abs(size) / jump.stddev[name] for name, size in jump.sizes.items() if jump.stddev[name]
    ]
    return Said(
        names=frozenset(jump.sizes),
        time=jump.time,
        time_sd=jump.time_stddev,
        clear=max(sizes, default=0.0),
        alternatives=jump.alternatives,
        new=jump.new,
        probability=getattr(jump, 'probability', np.nan),
        retracted=getattr(jump, 'retracted', False),
    )
