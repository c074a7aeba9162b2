"""Method and steps that a trial of a model is integrated by, and their error."""

from dataclasses import replace

import numpy as np

from obs_ros.core.model import Model
from obs_ros.core.record import Record
from obs_ros.core.typing import Array, IntArray
from obs_ros.integration.backends import Backend, Kernels, kernels_for
from obs_ros.integration.grid import Grid


def integrated(
    model: Model,
    record: Record,
    scale: Array,
    x0: Array,
    p: Array,
    backend: Backend | None = None,
) -> tuple[Kernels, IntArray, float]:
    """Return the rollouts and steps (K - 1,) for candidates x0 (n, B), p (q, B) over a record.

    With them comes the integration error of the first one, the largest at any output, in standard
    deviations `scale` (r,) of the noise.
    """
    kernels, grid = kernels_for(model, backend), Grid.of(model, record, scale)
    with np.errstate(all='ignore'):
        coarse, fine = (
            kernels.trajectories(replace(grid, steps=n * grid.steps), x0[:, :1], p[:, :1])[1]
            for n in (1, 2)
        )
        error = np.abs(coarse - fine)[:, :, 0].max(axis=0, initial=0.0) / scale
    return kernels, grid.steps, float(error.max()) if np.isfinite(error).all() else np.inf
