"""Rollouts of a plant that chooses and of a like one that does not, timed in turn."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from benchmarks.runner import cpu_seconds, repeats_for
from obs_ros import Model, Record
from obs_ros.core.typing import Array
from obs_ros.integration.backends import kernels_for
from obs_ros.integration.grid import Grid

CANDIDATES = 64
SAMPLES = 1000
MEASUREMENT = 0.005  # s of process time


class Row(NamedTuple):
    """Fastest of the measurements in ns per candidate-step, and the median ratio to the plain."""

    plant: str
    choice: str
    plain: float
    ours: float
    ratio: float


def measured(plant: str, choice: str, plain: Model, model: Model, rounds: int) -> Row:
    """Interleave the measurements of a plant that chooses and the one that does not."""
    calls = [rollout(each) for each in (plain, model)]
    pairs = [(call, repeats_for(call, MEASUREMENT)) for call in calls]
    times = np.array([[cpu_seconds(*pair) for pair in pairs] for _ in range(rounds)])
    unit = 1e9 / (CANDIDATES * (SAMPLES - 1))
    fastest = times.min(axis=0) * unit
    return Row(plant, choice, *map(float, fastest), float(np.median(times[:, 1] / times[:, 0])))


def rollout(model: Model) -> Callable[[], Array]:
    """Return a call that rolls candidates of the model out, after a check against NumPy."""
    grid, x0, p = window(model, SAMPLES, CANDIDATES)
    prefixes = np.array([SAMPLES])
    compiled = kernels_for(model, 'numba')
    short, few = np.array([50]), slice(0, 16)
    np.testing.assert_allclose(
        compiled.squares(grid, short, x0[:, few], p[:, few]),
        kernels_for(model, 'numpy').squares(grid, short, x0[:, few], p[:, few]),
        rtol=1e-9,
    )
    return lambda: compiled.squares(grid, prefixes, x0, p)


def window(model: Model, samples: int, candidates: int) -> tuple[Grid, Array, Array]:
    """Return a grid of samples one step apart, and states and parameters within the bounds."""
    rng = np.random.default_rng(0)
    t = model.max_step * np.arange(samples)
    u = rng.uniform(0.0, 1.0, (samples, len(model.inputs)))
    y = np.zeros((samples, len(model.outputs)))
    grid = Grid.of(model, Record(t, u, y), np.ones(len(model.outputs)))
    x0, p = (
        np.array([rng.uniform(v.lower, v.upper, candidates) for v in group])
        for group in (model.states, model.parameters)
    )
    return grid, x0, p
