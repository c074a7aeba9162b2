"""Report on the periods of a model: one period on, a state must be the same to its functions."""

from typing import Any

import numpy as np

from obs_ros.cli.model_trial import Trial
from obs_ros.core.model import Model, names
from obs_ros.core.periods import periods, shortest
from obs_ros.core.typing import Array

SAME = 1e-6  # of the largest value along a rollout: a sine of a large angle differs by rounding


def wrapping(model: Model, trial: Trial) -> list[str]:
    """Return a line for each state with a period that the model's functions do not have."""
    lines, mark = [], ' of the next node' if model.kind == 'discrete' else "'"
    rates, outputs = _along(model, trial, 0.0, 0)
    for i, variable in enumerate(model.states):
        if variable.period is None:
            continue
        others, seen = _along(model, trial, variable.period, i)
        turns, off = shortest(seen - outputs, periods(model.outputs)), others - rates
        if model.kind == 'discrete':  # the next state is as many periods on as the state
            off = shortest(off, periods(model.states))
        changed = [
            *(f'{name}{mark}' for name in _changed(names(model.states), rates, off)),
            *_changed(names(model.outputs), outputs, turns),
        ]
        if changed:
            lines.append(
                f'  give state {variable.name} no period, or write the model with its sine and '
                f'cosine: a period of {variable.period:.6g} on, {", ".join(changed)} differ'
            )
    return lines


def _along(model: Model, trial: Trial, turn: float, state: int) -> tuple[Array, Array]:
    """Return rates or next states (K, n) and outputs (K, r) along the trial, a state so far off."""
    states = trial.states.copy()
    states[:, state] += turn
    t, x, u = trial.record.t, tuple(states.T), tuple(trial.record.u.T)

    def columns(values: Any) -> Array:
        return np.column_stack([np.broadcast_to(each, t.size) for each in values])

    with np.errstate(all='ignore'):
        p = tuple(trial.p)
        return columns(model.dynamics(t, x, u, p)), columns(model.output(t, x, u, p))


def _changed(names: tuple[str, ...], values: Array, differences: Array) -> list[str]:
    """Return the names of the columns (K, n) that differ by more than rounding."""
    off = np.abs(differences).max(axis=0) > SAME * (1.0 + np.abs(values).max(axis=0))
    return [name for name, changed in zip(names, off, strict=True) if changed]
