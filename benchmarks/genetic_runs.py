"""Observers on the plants of Porter & Passino 1995 and Gremling & Passino 2000, run by run."""

import functools
import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from obs_ros import Sample, load_observer
from obs_ros.model import Model
from obs_ros.models import load_model
from obs_ros.observers.euler import euler_step
from obs_ros.typing import Array
from plant_sim.scenarios import load_scenario
from plant_sim.simulation import Simulation

PERIOD = 0.01  # s
BAD = 1e3  # an error beyond which an observer counts as diverged
SETTLED = 0.05  # of x2


class Truth(NamedTuple):
    """What a scenario's plant did: t (K,), states x (K, n), inputs u (K, m), outputs y (K, r)."""

    t: Array
    x: Array
    u: Array
    y: Array


@dataclass(frozen=True)
class Way:
    """An observer of the registry, or `constant gain` or `open loop`, and how it is set."""

    label: str
    observer: str
    settings: Mapping[str, Any] = field(default_factory=dict)
    seeded: bool = False


@dataclass(frozen=True)
class Run:
    """One observer to be run on one scenario."""

    scenario: str
    way: Way
    seed: int
    keep: bool = False  # the whole run, for the pictures


@dataclass(frozen=True)
class Outcome:
    """Errors of a run and how often it started again; the rest only where it is kept."""

    rms: Array  # (n,) over the second half
    squares: Array  # (n,) sums over the whole run
    settled: float  # s, when x2 was within 0.05 for good; infinite if never
    resets: int
    largest: float  # error of x2
    seconds: float  # process time for a sample
    t: Array | None = None
    x: Array | None = None  # (K, n), estimated
    truth: Array | None = None
    figures: Array | None = None  # (K, F), in the order of their names
    figure_names: tuple[str, ...] = ()


@functools.lru_cache(maxsize=8)
def truth_of(name: str, seed: int) -> Truth:
    """Play a scenario; the seed is that of random inputs."""
    scenario = load_scenario(name)
    simulation = Simulation(scenario, seed=seed)
    count = round(scenario.duration / PERIOD) + 1
    instants = [simulation.sample() for _ in range(count)]
    columns = ([getattr(i, part) for i in instants] for part in 'xuy')
    return Truth(PERIOD * np.arange(count), *(np.array(column) for column in columns))


def run(task: Run) -> Outcome:
    """Run one observer and judge it by the true states."""
    truth = truth_of(task.scenario, task.seed)
    model = load_model(load_scenario(task.scenario).model)
    special = {'constant gain': constant_gain, 'open loop': open_loop}
    figures: list[dict[str, float]] = []
    resets, seconds = 0, np.nan
    if task.way.observer in special:
        with np.errstate(all='ignore'):
            x = special[task.way.observer](model, truth, **task.way.settings)
    else:
        seed = {'seed': task.seed} if task.way.seeded else {}
        observer = load_observer(task.way.observer)(model, **seed, **task.way.settings)
        observer.prepare()
        samples = [
            Sample(round(t * 1e9), y=y, u=u)
            for t, u, y in zip(truth.t, truth.u, truth.y, strict=True)
        ]
        x = np.empty_like(truth.x)
        begin = time.process_time()
        for k, sample in enumerate(samples):
            observer.absorb(sample)
            estimate = observer.estimate()
            x[k] = list(estimate.state.values())
            figures.append(dict(estimate.figures))
        seconds = (time.process_time() - begin) / len(samples)
        resets = observer.counts['reset_non_finite']
    return judged(task, truth, x, resets, seconds, figures)


def judged(
    task: Run,
    truth: Truth,
    x: Array,
    resets: int,
    seconds: float,
    figures: list[dict[str, float]],
) -> Outcome:
    """Compare estimated with true states."""
    error = x - truth.x
    half = len(truth.t) // 2
    late = np.flatnonzero(~(np.abs(error[:, 1]) < SETTLED))
    settled = (late[-1] + 1) * PERIOD if late.size else 0.0
    kept: dict[str, Any] = {}
    if task.keep:
        names = tuple(figures[-1]) if figures else ()
        rows = [[row.get(name, np.nan) for name in names] for row in figures]
        kept = {
            't': truth.t, 'x': x, 'truth': truth.x, 'figures': np.array(rows),
            'figure_names': names,
        }  # fmt: skip
    with np.errstate(over='ignore'):  # of one that diverged
        squares = error**2
    return Outcome(
        rms=np.sqrt(squares[half:].mean(axis=0)),
        squares=squares.sum(axis=0),
        settled=settled if settled <= truth.t[-1] else np.inf,
        resets=resets,
        largest=float(np.abs(error[:, 1]).max()),
        seconds=seconds,
        **kept,
    )


def constant_gain(model: Model, truth: Truth, gains: tuple[float, ...]) -> Array:
    """Run the genetic observer's equation with one gain: forward Euler, y = x1, from 0."""
    p = np.array([variable.nominal for variable in model.parameters])
    x = np.zeros_like(truth.x)
    for k in range(len(truth.t) - 1):
        error = truth.y[k, 0] - x[k, 0]
        step = euler_step(model, truth.t[k], PERIOD, x[k], truth.u[k], p)
        x[k + 1] = step + np.array(gains) * error
    return x


def open_loop(model: Model, truth: Truth) -> Array:
    """Run the model with its parameters in the middle of their ranges, uncorrected, from 0."""
    p = np.array([0.5 * (variable.lower + variable.upper) for variable in model.parameters])
    x = np.zeros_like(truth.x)
    for k in range(len(truth.t) - 1):
        x[k + 1] = euler_step(model, truth.t[k], PERIOD, x[k], truth.u[k], p)
    return x


def diverged(outcome: Outcome) -> bool:
    """Whether an observer had to start again, or was far off."""
    return outcome.resets > 0 or not outcome.largest < BAD
