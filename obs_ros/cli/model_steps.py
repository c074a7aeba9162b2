"""Method and steps that a trial of a model is integrated by: those of a window's search."""

from dataclasses import replace

import numpy as np

from obs_ros.core.model import Model, names
from obs_ros.core.record import Record
from obs_ros.core.typing import Array
from obs_ros.horizon.integration_error import Answer
from obs_ros.horizon.settings import EstimationSettings
from obs_ros.horizon.solver import Solver
from obs_ros.inference.window_state import WindowState
from obs_ros.integration.backends import Backend, Kernels
from obs_ros.integration.grid import Grid

ROUNDS = 3  # in which steps get finer


def integrated(
    model: Model,
    record: Record,
    scale: Array,
    x0: Array,
    p: Array,
    backend: Backend | None = None,
) -> tuple[Kernels, Grid, float]:
    """Return the rollouts for a record and a grid in their steps, beside x0 (n,), p (q,).

    With them comes the integration error there, the largest at any output, in standard deviations
    `scale` (r,) of the noise.
    """
    noise = dict(zip(names(model.outputs), scale.tolist(), strict=True))
    settings = EstimationSettings(noise=noise, process_noise='off', backend=backend)
    solver = Solver.of(model, settings)
    unknowns = solver.unknowns
    z = unknowns.point(dict(zip(names(model.variables), (*x0, *p), strict=True)))
    with np.errstate(all='ignore'):
        window = solver.integration.begun(solver.pose(record, scale, noise_known=True), z, None)
        for _ in range(ROUNDS):
            window = _measuring_itself(window, z)
            answer = Answer.of(window, z)
            if answer.fine or not np.isfinite(answer.error):
                break
            finer = solver.integration.finer(window, answer)
            if finer is window:
                break
            window = finer
    objective = window.objective
    grid = solver.integration.counted(window, z).objective.grid
    return objective.kernels, grid, answer.error


def _measuring_itself(window: WindowState, z: Array) -> WindowState:
    """Return a window whose outputs are those of its own point z (d,), where these are finite."""
    objective = window.objective
    outputs = objective.trajectory(z)[1] / objective.grid.weight + objective.grid.y
    if not np.isfinite(outputs).all():
        return window
    return replace(window, objective=replace(objective, grid=replace(objective.grid, y=outputs)))
