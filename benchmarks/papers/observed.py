"""Observers that watch the plants of the genetic papers, run by run, judged by the true states."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from benchmarks.papers.baselines import BASELINES
from benchmarks.papers.seeds import seeds_of
from benchmarks.papers.truth import PERIOD, Truth, has_random_input, truth_of
from benchmarks.play import Contestant
from benchmarks.report import rms
from obs_ros import Sample, load_model, load_observer
from obs_ros.core.typing import Array
from plant_sim.scenarios import load_scenario

BAD = 1e3  # an error beyond which an observer counts as diverged
SETTLED = 0.05  # of x2
GROWN = 0.5  # of the second state: stall cells that count as grown


class Run(NamedTuple):
    """A run of an observer on a scenario: seeds of the input and of the observer."""

    scenario: str
    way: Contestant
    input_seed: int
    own_seed: int
    keep: bool  # the whole run, for the pictures


@dataclass(frozen=True)
class Trace:
    """A whole run: t (K,), estimated and true states (K, n), figures by name (K,)."""

    t: Array
    x: Array
    truth: Array
    figures: dict[str, Array]


@dataclass(frozen=True)
class Outcome:
    """Errors of a run, how often it started again, and what its observer told of itself."""

    rms: Array  # (n,) of the errors over the second half
    size: Array  # (n,) RMS of the true states there
    squares: Array  # (n,) sums over the whole run
    settled: float  # s, when x2 was within 0.05 for good; infinite if never
    resets: int
    largest: Array  # (n,) error of each state over the whole run
    onset: float  # s after the truth, when x2 first is above 0.5; infinite if never
    frozen: float = np.inf  # s, when gains froze; infinite if never
    last: dict[str, float] = field(default_factory=dict)  # the observer's figures at the end
    trace: Trace | None = None


def runs_of(paper: str, scenario: str, way: Contestant, count: int) -> list[tuple[Run]]:
    """Return `count` independent runs, one where nothing is random; the first one is kept whole.

    All observers on a scenario see the same inputs, and draw from streams of their own.
    """
    random = has_random_input(scenario)
    count = count if way.seeded or random else 1
    inputs = seeds_of(paper, f'input of {scenario}', count)
    own = seeds_of(paper, f'{way.label} on {scenario}', count)
    seeds = enumerate(zip(inputs, own, strict=True))
    return [(Run(scenario, way, *pair, keep=k == 0),) for k, pair in seeds]


def observe(run: Run) -> Outcome:
    """Run an observer of the registry, or a baseline, and judge it by the true states."""
    truth = truth_of(run.scenario, run.input_seed)
    model, way = load_model(load_scenario(run.scenario).model), run.way
    if way.observer in BASELINES:
        with np.errstate(all='ignore'):
            x = BASELINES[way.observer](model, truth, **way.settings)
        return judged(run.keep, truth, x, 0, [])
    seeded = {'seed': run.own_seed} if way.seeded else {}
    observer = load_observer(way.observer)(model, **seeded, **way.settings)
    observer.prepare()
    states, figures = [], []
    for t, u, y in zip(truth.t, truth.u, truth.y, strict=True):
        observer.absorb(Sample(round(t * 1e9), y=y, u=u))
        estimate = observer.estimate()
        assert estimate is not None  # one for each output
        states.append(list(estimate.state.values()))
        figures.append(dict(estimate.figures))
    resets = observer.counts['reset_non_finite']
    return judged(run.keep, truth, np.array(states), resets, figures)


def judged(
    keep: bool, truth: Truth, x: Array, resets: int, figures: Sequence[dict[str, float]]
) -> Outcome:
    """Compare estimated states x (K, n) with the true ones."""
    error = x - truth.x
    half = len(truth.t) // 2
    late = np.flatnonzero(~(np.abs(error[:, 1]) < SETTLED))
    settled = (late[-1] + 1) * PERIOD if late.size else 0.0
    told = {name: np.array([one.get(name, np.nan) for one in figures]) for name in names(figures)}
    with np.errstate(over='ignore'):  # of one that diverged
        squares, late_rms = (error**2).sum(axis=0), rms(error[half:], 0)
    return Outcome(
        rms=late_rms,
        size=rms(truth.x[half:], 0),
        squares=squares,
        settled=settled if settled <= truth.t[-1] else np.inf,
        resets=resets,
        largest=np.abs(error).max(axis=0),
        onset=first_time(x[:, 1] > GROWN) - first_time(truth.x[:, 1] > GROWN),
        frozen=first_time(told.get('frozen', np.zeros(0)) == 1.0),
        last=dict(figures[-1]) if figures else {},
        trace=Trace(truth.t, x, truth.x, told) if keep else None,
    )


def names(figures: Sequence[dict[str, float]]) -> list[str]:
    """Return the names of an observer's figures, as they come."""
    return list(dict.fromkeys(name for one in figures for name in one))


def first_time(true: Any) -> float:
    """Return the time (s) of the first sample at which something holds; infinite if at none."""
    at = np.flatnonzero(true)
    return float(at[0] * PERIOD) if at.size else np.inf


def diverged(outcome: Outcome) -> bool:
    """True if an observer had to start again, or was far off in any state."""
    return outcome.resets > 0 or not bool((outcome.largest < BAD).all())
