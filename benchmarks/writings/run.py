"""Rollouts of one plant, written in many ways, timed in turn."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from benchmarks.runner import cpu_seconds, repeats_for
from benchmarks.writings.models import WRITINGS, pendulums, scalars
from obs_ros import Model, Record
from obs_ros.core.typing import Array
from obs_ros.integration.backends import kernels_for
from obs_ros.integration.grid import Grid

CANDIDATES = 64
SAMPLES = 40, 1000  # without and with a compiler
MEASUREMENT = 0.005  # s of process time


class Row(NamedTuple):
    """Fastest of the measurements in ns per candidate-step, and the median ratio to scalars."""

    backend: str
    writing: str
    ours: float
    ratio: float


def measured(rounds: int) -> list[Row]:
    """Interleave the measurements of all ways of writing, backend by backend."""
    rows = []
    for backend, samples in zip(('numpy', 'numba'), SAMPLES, strict=True):
        models = {'scalars': pendulums(scalars)}
        models |= {name: pendulums(function) for name, function in WRITINGS.items()}
        calls = {name: rollout(model, backend, samples) for name, model in models.items()}
        wanted = calls['scalars']()
        for call in calls.values():
            np.testing.assert_allclose(call(), wanted, rtol=1e-9)
        repeats = {name: repeats_for(call, MEASUREMENT) for name, call in calls.items()}
        times = np.array(
            [[cpu_seconds(call, repeats[name]) for name, call in calls.items()]
             for _ in range(rounds)]
        )  # fmt: skip
        unit = 1e9 / (CANDIDATES * (samples - 1))
        ratios = np.median(times / times[:, :1], axis=0)
        rows += [
            Row(backend, name, float(fastest), float(ratio))
            for name, fastest, ratio in zip(calls, times.min(axis=0) * unit, ratios, strict=True)
        ]
    return rows


def rollout(model: Model, backend: str, samples: int) -> Callable[[], Array]:
    """Return a call that rolls candidates of the model out."""
    rng = np.random.default_rng(0)
    t = model.max_step * np.arange(samples)
    u = rng.uniform(-3.0, 3.0, (samples, 1))
    grid = Grid.of(model, Record(t, u, np.zeros((samples, 2))), np.ones(2))
    x0, p = (
        np.array([rng.uniform(v.lower, v.upper, CANDIDATES) for v in group])
        for group in (model.states, model.parameters)
    )
    kernels, prefixes = kernels_for(model, backend), np.array([samples])  # type: ignore[arg-type]
    return lambda: kernels.squares(grid, prefixes, x0, p)
