"""Outputs along the fitted path, to be seen beside the measured ones."""

import numpy as np

from obs_ros.core.model import Model
from obs_ros.core.periods import periods, within
from obs_ros.core.typing import Array
from obs_ros.replay.history import History

DRAWS = 5  # random points at which an output is compared with a state: chance makes none equal


def outputs_of_states(model: Model) -> dict[int, int]:
    """Return the outputs that are a state themselves: the output's index by that of the state."""
    random = np.random.default_rng(0)
    n, m, q = len(model.states), len(model.inputs), len(model.parameters)
    found: dict[int, int] = {}
    draws = random.uniform(0.1, 0.9, (DRAWS, n + m + q))
    with np.errstate(all='ignore'):
        outputs = [
            model.output(0.0, tuple(d[:n]), tuple(d[n : n + m]), tuple(d[n + m :])) for d in draws
        ]
    for state in range(n):
        for output in range(len(model.outputs)):
            if all(y[output] == d[state] for y, d in zip(outputs, draws, strict=True)):
                found.setdefault(state, output)
    return found


def fitted_outputs(history: History) -> Array:
    """Return the outputs (K, r) at the times of the fitted path, inputs held as they came."""
    model, path = history.model, history.path
    n, rows = len(model.states), path.rows
    inputs = _held(history)
    columns = (tuple(values.T) for values in (rows[:, :n], inputs, rows[:, n:]))
    with np.errstate(all='ignore'):
        outputs = model.output(path.stamps / 1e9, *columns)
    found = np.column_stack([np.broadcast_to(y, len(path)) for y in outputs]).astype(np.float64)
    return within(found, periods(model.outputs))


def _held(history: History) -> Array:
    """Return the inputs (K, m) in force at the times of the path; NaN before they were known."""
    stamps, trace = history.path.stamps, history.applied
    held = np.full((stamps.size, trace.width), np.nan)
    for column in range(trace.width):
        values = trace.rows[:, column]
        known = np.isfinite(values)
        place = np.searchsorted(trace.stamps[known], stamps, side='right') - 1
        held[place >= 0, column] = values[known][place[place >= 0]]
    return held
