"""Observers on the plants of Porter & Passino 1995 and Gremling & Passino 2000, run by run."""

import functools
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from benchmarks.play import Contestant, columns, followed, played
from benchmarks.report import rms
from obs_ros import Model, Record, Sample, load_model, load_observer
from obs_ros.core.deadline import Deadline
from obs_ros.core.model import names
from obs_ros.core.typing import Array
from obs_ros.inference.objective import Objective
from obs_ros.inference.parameterisation import Unknowns
from obs_ros.integration.backends import kernels_for
from obs_ros.integration.grid import Grid
from obs_ros.observers.papers.euler import euler_step
from obs_ros.optimization.levenberg_marquardt import levenberg_marquardt
from plant_sim.scenarios import load_scenario
from plant_sim.sources import WhiteGaussian

PERIOD = 0.01  # s
BAD = 1e3  # an error beyond which an observer counts as diverged
SETTLED = 0.05  # of x2
ITERATIONS = 100  # of Levenberg-Marquardt, at most


class Truth(NamedTuple):
    """A scenario's truth: times t (K,), states x (K, n), inputs u (K, m), outputs y (K, r)."""

    t: Array
    x: Array
    u: Array
    y: Array


@dataclass(frozen=True)
class Outcome:
    """Errors of a run and how often it started again; the rest only where it is kept."""

    rms: Array  # (n,) over the second half
    squares: Array  # (n,) sums over the whole run
    settled: float  # s, when x2 was within 0.05 for good; infinite if never
    resets: int
    largest: float  # error of x2
    seconds: float  # process time for a sample, median
    t: Array | None = None
    x: Array | None = None  # (K, n), estimated
    truth: Array | None = None
    figures: Array | None = None  # (K, F), in the order of their names
    figure_names: tuple[str, ...] = ()


@functools.cache
def truth_of(name: str, seed: int) -> Truth:
    """Play a scenario; the seed is that of random inputs, without which all runs are the same."""
    scenario = load_scenario(name)
    if seed and not isinstance(scenario.inputs, WhiteGaussian):
        return truth_of(name, 0)
    count = round(scenario.duration / PERIOD) + 1
    x, u, y = columns(played(scenario, count, seed=seed), 'xuy')
    return Truth(PERIOD * np.arange(count), x, u, y)


def run(scenario: str, way: Contestant, seed: int, keep: bool = False) -> Outcome:
    """Run one observer and judge it by the true states; `keep` the whole run, for the pictures.

    The observer is one of the registry, or of SPECIAL.
    """
    truth = truth_of(scenario, seed)
    model = load_model(load_scenario(scenario).model)
    figures: list[dict[str, float]] = []
    resets, seconds = 0, np.nan
    if way.observer in SPECIAL:
        with np.errstate(all='ignore'):
            x = SPECIAL[way.observer](model, truth, **way.settings)
    else:
        seeded = {'seed': seed} if way.seeded else {}
        observer = load_observer(way.observer)(model, **seeded, **way.settings)
        samples = [
            Sample(round(t * 1e9), y=y, u=u)
            for t, u, y in zip(truth.t, truth.u, truth.y, strict=True)
        ]
        estimates, times = followed(observer, samples)
        x = np.array([list(estimate.state.values()) for estimate in estimates])
        figures = [dict(estimate.figures) for estimate in estimates]
        seconds = float(np.median(times[:, 1]))
        resets = observer.counts['reset_non_finite']
    return judged(keep, truth, x, resets, seconds, figures)


def judged(
    keep: bool, truth: Truth, x: Array, resets: int, seconds: float, figures: list[dict[str, float]]
) -> Outcome:
    """Compare estimated with true states."""
    error = x - truth.x
    half = len(truth.t) // 2
    late = np.flatnonzero(~(np.abs(error[:, 1]) < SETTLED))
    settled = (late[-1] + 1) * PERIOD if late.size else 0.0
    kept: dict[str, Any] = {}
    if keep:
        names = tuple(figures[-1]) if figures else ()
        rows = [[row.get(name, np.nan) for name in names] for row in figures]
        kept = {
            't': truth.t, 'x': x, 'truth': truth.x, 'figures': np.array(rows),
            'figure_names': names,
        }  # fmt: skip
    with np.errstate(over='ignore'):  # of one that diverged
        squares, late_rms = (error**2).sum(axis=0), rms(error[half:], 0)
    return Outcome(
        rms=late_rms,
        squares=squares,
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


def window_fit(model: Model, truth: Truth, window: int) -> Array:
    """Fit the genetic estimator's windows by Levenberg-Marquardt alone, from the fit before.

    Parameters only, within their bounds: a window begins at the measured output and the hidden
    states estimated there, as for the genetic algorithm. The states are those at its end.
    """
    kernels, states = kernels_for(model), names(model.states)
    x = np.zeros_like(truth.x)
    p = {v.name: 0.5 * (v.lower + v.upper) for v in model.parameters}
    for k in range(1, len(truth.t)):
        first = max(0, k - window - 1)
        start = np.concatenate([truth.y[first], x[first, 1:]])
        unknowns = Unknowns.of(model, None, (), dict(zip(states, start, strict=True)))
        rows = slice(first, k + 1)
        record = Record(truth.t[rows], truth.u[rows], truth.y[rows])
        objective = Objective(kernels, Grid.of(model, record, np.ones(1)), unknowns)
        z = unknowns.point(p)[None]
        z = levenberg_marquardt(objective, z, objective.nodes, ITERATIONS, Deadline()).z[0]
        x[k] = objective.trajectory(z)[0][-1]
        p = dict(zip(unknowns.names, unknowns.values(z[None])[1][:, 0], strict=True))
    return x


SPECIAL: Mapping[str, Callable[..., Array]] = {
    'constant gain': constant_gain, 'open loop': open_loop, 'window fit': window_fit
}  # fmt: skip


def diverged(outcome: Outcome) -> bool:
    """True if an observer had to start again, or was far off."""
    return outcome.resets > 0 or not outcome.largest < BAD
