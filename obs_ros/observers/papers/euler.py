"""One step of forward Euler from sample to sample, as the genetic observers take it."""

import numpy as np

from obs_ros.core.model import Model
from obs_ros.core.typing import Array
from obs_ros.integration.path import Path
from obs_ros.integration.steps import euler


def mean_inputs(path: Path) -> Array:
    """Return the inputs (m,) averaged over the path; what was held all along, as it was."""
    pieces = path.pieces
    if pieces == 1:
        return np.asarray(path.u[0] + 0.5 * path.dt[0] * path.slope[0])
    dt = path.dt[:pieces, None]
    middle = path.u[:pieces] + 0.5 * dt * path.slope[:pieces]
    return np.asarray((dt * middle).sum(axis=0) / dt.sum())


def euler_step(model: Model, t: float, h: float, x: Array, u: Array, p: Array) -> Array:
    """Return the states h seconds on, of one candidate, x (n,), or of many, x (n, N)."""
    return np.array(euler(model.dynamics, t, h, tuple(x), u, u, u, tuple(p)))


def outputs_of(model: Model, t: float, x: Array, u: Array, p: Array) -> Array:
    """Return the outputs (r,) of one candidate, x (n,), or (r, N) of many, x (n, N)."""
    return np.array(model.output(t, tuple(x), tuple(u), tuple(p)))
