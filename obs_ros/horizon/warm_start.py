"""Carry an estimate forward to the start of a later window (Yang 2020, section 4.4.2)."""

from collections.abc import Mapping

import numpy as np

from obs_ros.core.estimate import Estimate
from obs_ros.core.model import names
from obs_ros.core.record import Record
from obs_ros.core.typing import Array
from obs_ros.integration.backends import Kernels
from obs_ros.integration.grid import Grid


def propagated(kernels: Kernels, previous: Estimate, record: Record) -> Mapping[str, float]:
    """Return the states that the previous estimate expects at the record's first sample.

    Within the previous window they are read off its trajectory; beyond, the model runs on with
    the record's first inputs held. Across a gap longer than the record, or backwards in time,
    the nearest estimated state must do.
    """
    t0 = float(record.t[0])
    gap = t0 - previous.t1
    if not 0.0 < gap <= record.t[-1] - record.t[0]:
        state = [np.interp(t0, previous.times, column) for column in previous.states.T]
    else:
        state = list(_run_on(kernels, previous, record))
    return {
        name: float(value) for name, value in zip(names(kernels.model.states), state, strict=True)
    }


def _run_on(kernels: Kernels, previous: Estimate, record: Record) -> Array:
    model = kernels.model
    bridge = Record(
        t=np.array([previous.t1, record.t[0]]),
        u=np.tile(record.u[0], (2, 1)),
        y=np.zeros((2, len(model.outputs))),
    )
    grid = Grid.of(model, bridge, np.ones(len(model.outputs)), previous.t0)
    x0 = np.array([[previous.state[name]] for name in names(model.states)])
    p = np.array([previous.parameters[name] for name in names(model.parameters)]).reshape(-1, 1)
    states, _ = kernels.trajectories(grid, x0, p)
    return states[-1, :, 0]
