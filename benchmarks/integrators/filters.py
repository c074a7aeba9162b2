"""Filters on the stiff plants, beside the same filters in steps so fine that no error is left."""

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from benchmarks.integrators.plants import PLANTS
from benchmarks.integrators.run import drawn
from benchmarks.play import followed
from obs_ros import Sample
from obs_ros.observers.base import load_observer

FILTERS = 'ekf', 'ukf'
FINER = 200  # steps between two samples; RK4 is stable there on the plants that are followed
FOLLOWED = 'motor, L/R 1 ms', 'van der Pol 10', 'buck converter', 'battery'


class Followed(NamedTuple):
    """A filter along a window: the greatest difference to fine steps, in the filter's deviations.

    Infinite where it diverged.
    """

    plant: str
    filter: str
    difference: float
    fine: float


def solved(name: str, filter_: str, seed: int) -> Followed:
    """Run a filter over a window of a plant, as it is and in fine steps."""
    plant = PLANTS[name]
    window = drawn(plant, plant.model, seed)
    record = window.record
    samples = [
        Sample(round(t * 1e9), y=y, u=u)
        for t, y, u in zip(record.t, record.y, record.u, strict=True)
    ]
    noise = {v.name: s for v, s in zip(plant.model.outputs, window.noise.tolist(), strict=True)}
    period = float(np.diff(record.t).max())
    fine = replace(plant.model, integrator='rk4', max_step=period / FINER)
    own, exact = (_run(filter_, model, samples, noise) for model in (plant.model, fine))
    if own is None or exact is None:
        return Followed(name, filter_, np.inf, float(exact is not None))
    (values, _), (wanted, deviations) = own, exact
    return Followed(name, filter_, float(np.max(np.abs(values - wanted) / deviations)), 1.0)


def _run(filter_: str, model: Any, samples: list[Sample], noise: dict[str, float]) -> Any:
    observer = load_observer(filter_)(model, noise=noise)
    estimates, _ = followed(observer, samples)
    usable = [estimate for estimate in estimates if estimate is not None and estimate.usable]
    if len(usable) < len(samples) // 2 or not estimates[-1].usable:
        return None
    names = [variable.name for variable in model.variables]
    values = [[{**e.state, **e.parameters}[name] for name in names] for e in usable]
    deviations = [[e.stddev[name] for name in names] for e in usable]
    return np.array(values), np.array(deviations)
