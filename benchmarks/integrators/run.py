"""Random windows of each plant: solved, and held against the reference."""

from typing import Any, NamedTuple

import numpy as np

from benchmarks.integrators.plants import PLANTS, Plant
from benchmarks.integrators.reference import RTOL, Reference, outputs
from benchmarks.judge import SAME_OPTIMUM
from benchmarks.runner import timed
from obs_ros import Estimate, Model, Record, solve_window
from obs_ros.core.typing import Array

INNER = 0.15, 0.85  # of the box: where the truth lies
SNR = 100.0  # 40 dB against an output's own deviation
FINE = 1e-10  # relative tolerance of what integration errors are measured against
REPEATS = 3


class Window(NamedTuple):
    """A record, its truth (d,) and the noise (r,)."""

    record: Record
    truth: Array
    noise: Array


class Solved(NamedTuple):
    """One window: outcome, squares above the reference's optimum, error of integration in sd.

    `error` is the greatest difference between the outputs that belong to the estimate and those of
    the reference, NaN where nothing was accepted. `seconds` are process time.
    """

    plant: str
    outcome: str
    excess: float
    margin: float
    error: float
    claimed: float
    seconds: float
    mild: float

    @property
    def at_the_optimum(self) -> bool:
        """Whether the squares are those of the optimum, or less."""
        return self.excess <= self.margin


def drawn(plant: Plant, model: Model, seed: int) -> Window:
    """Return a window by seed; the truth is integrated by scipy."""
    rng = np.random.default_rng([seed, *plant.name.encode()])
    t = plant.t
    for _ in range(50):
        u = plant.inputs(rng, t)
        p = np.array([_inside(rng, v) for v in model.parameters])
        x0 = np.array([_inside(rng, v) for v in model.states])
        if plant.start is not None:
            x0 = plant.start(rng, p)
        y = outputs(model, t, u, x0, p)
        noise = y.std(axis=0) / SNR
        if np.isfinite(y).all() and (noise > 0.0).all():
            record = Record(t, u, y + noise * rng.standard_normal(y.shape))
            return Window(record, np.concatenate([x0, p]), noise)
    raise ValueError(f'{plant.name}: no window among fifty')


def _inside(rng: np.random.Generator, variable: Any) -> float:
    share = rng.uniform(*INNER)
    if variable.scale == 'log':
        return float(variable.lower * (variable.upper / variable.lower) ** share)
    return float(variable.lower + share * (variable.upper - variable.lower))


def estimate_of(model: Model, window: Window, seed: int) -> Estimate:
    """Solve a window."""
    names = [variable.name for variable in model.outputs]
    noise = dict(zip(names, window.noise.tolist(), strict=True))
    return solve_window(model, window.record, seed=seed, noise=noise, process_noise='off')


def solved(name: str, seed: int, refer: bool = True) -> Solved:
    """Solve a window of a plant and one of its mild twin, and judge the first."""
    plant = PLANTS[name]
    window = drawn(plant, plant.model, seed)
    estimate, seconds = best_of(plant.model, window, seed)
    try:
        _, mild = best_of(plant.mild, drawn(plant, plant.mild, seed), seed)
    except ValueError:
        mild = np.nan
    excess = error = np.nan
    if refer:
        excess = np.inf
        if estimate.usable:
            values = np.array([*estimate.initial_state.values(), *estimate.parameters.values()])
            reference = Reference(plant.model, window.record, window.noise)
            excess = reference.squares(values) - reference.optimum(window.truth)
            if np.isfinite(list(estimate.stddev.values())).any() or estimate.outcome == 'converged':
                error = integration_error(plant.model, window, estimate, values)
    claimed = float(estimate.figures.get('integration_error_sd', np.nan))
    margin = SAME_OPTIMUM * window.truth.size
    outcome = str(estimate.outcome.value)
    return Solved(name, outcome, excess, margin, error, claimed, seconds, mild)


def best_of(model: Model, window: Window, seed: int) -> tuple[Estimate, float]:
    """Return the estimate of a window, and the least process time of some, compiled."""
    estimate_of(model, window, seed)
    runs = [timed(lambda: estimate_of(model, window, seed)) for _ in range(REPEATS)]
    return runs[0][0], min(seconds for _, seconds in runs)


def integration_error(model: Model, window: Window, estimate: Estimate, values: Array) -> float:
    """Return the greatest error of the estimate's outputs in deviations of the noise."""
    n, record = len(model.states), window.record
    exact = outputs(model, record.t, record.u, values[:n], values[n:], rtol=FINE)
    rows = zip(record.t, estimate.states, record.u, strict=True)
    own = np.array([model.output(t, tuple(x), tuple(u), tuple(values[n:])) for t, x, u in rows])
    return float(np.max(np.abs(own - exact) / window.noise))


__all__ = ['RTOL', 'Solved', 'Window', 'drawn', 'estimate_of', 'integration_error', 'solved']
