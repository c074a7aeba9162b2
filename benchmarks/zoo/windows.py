"""Draw a window: truth, simulation in fine steps, noise."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from benchmarks.zoo.cases import Case
from obs_ros import Record
from obs_ros.core.model import names
from obs_ros.integration.backends import kernels_for
from obs_ros.integration.grid import Grid

FINER = 10  # steps of the simulated plant in one of the model


@dataclass(frozen=True)
class Drawn:
    """A window of measurements, its noise by output, and the true unknowns at its start."""

    record: Record
    noise: Mapping[str, float]
    truth: Mapping[str, float]


def draw(case: Case, seed: int) -> Drawn:
    """Return the window of that seed."""
    rng = np.random.default_rng(seed)
    model = case.model
    low, high = case.inner
    truth = np.array(
        [v.lower + rng.uniform(low, high) * (v.upper - v.lower) for v in model.variables]
    )
    before = round(case.settle / case.period)
    t = case.period * np.arange(before + case.samples)
    u = case.inputs(rng, t)
    x0, p = np.split(truth[:, None], [len(model.states)])
    blank = Record(t, u, np.zeros((t.size, len(model.outputs))))
    fine = replace(model, max_step=min(model.max_step, case.period) / FINER)
    grid = Grid.of(fine, blank, np.ones(len(model.outputs)))
    states, outputs = (
        found[before:, :, 0] for found in kernels_for(model).trajectories(grid, x0, p)
    )
    unit = np.ones(outputs.shape[1]) if case.unit_power else outputs.std(axis=0)
    noise = unit * 10 ** (-case.snr_db / 20)
    measured = outputs + noise * rng.standard_normal(outputs.shape)
    truth[: len(model.states)] = states[0]
    return Drawn(
        Record(t[before:], u[before:], measured),
        dict(zip(names(model.outputs), noise.tolist(), strict=True)),
        dict(zip(names(model.variables), truth.tolist(), strict=True)),
    )
