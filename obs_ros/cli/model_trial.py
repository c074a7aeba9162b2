"""A trial rollout of a model, from its nominal values over one window."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from obs_ros.core.model import Model, Variable, inside, names
from obs_ros.core.record import Record
from obs_ros.core.texts import quoted
from obs_ros.core.typing import Array
from obs_ros.integration.backends import Kernels
from obs_ros.integration.grid import Grid


@dataclass(frozen=True)
class TrialSettings:
    """The window of a trial, where the user does not give it."""

    steps: int = 1000  # of the model, in a window: some microseconds for each candidate
    duration: float = 10.0  # s of a window, where the model names no step
    samples: int = 200  # in a window, where the model names no step
    most_samples: int = 1_000_000  # 8 MB for each variable
    cycles: tuple[float, float] = (3.0, 8.0)  # of a moving input's two cosines, in the window


TRIAL = TrialSettings()


@dataclass(frozen=True)
class Trial:
    """A window of `record` simulated from x0 (n,) with parameters p (q,), states (K, n)."""

    record: Record
    x0: Array
    p: Array
    states: Array

    def grid(self, model: Model, scale: Array | None = None) -> Grid:
        """Return the window's grid, its outputs of noise `scale` (r,)."""
        return Grid.of(model, self.record, np.ones(len(model.outputs)) if scale is None else scale)

    def steps(self, model: Model) -> int:
        """Return the number of the model's steps over the window."""
        return int(self.grid(model).steps.sum())


def axis(
    model: Model,
    window: float | None = None,
    period: float | None = None,
    settings: TrialSettings = TRIAL,
) -> tuple[float, float]:
    """Return the length of the window and the sample period (s), given or from the model's step.

    Raises ValueError for a window with fewer than three samples or too many.
    """
    step = model.max_step
    length = window or (settings.steps * step if math.isfinite(step) else settings.duration)
    every = period or (step if math.isfinite(step) else length / settings.samples)
    for name, value in (('--window', length), ('--period', every)):
        if not (math.isfinite(value) and value > 0.0):
            raise ValueError(f'{name} must be a positive time in s, not {value}')
    if model.period is not None and abs(every / model.period - round(every / model.period)) > 1e-6:
        raise ValueError(
            f'--period must be a multiple of the period of model {quoted(model.name)}, '
            f'{model.period:g} s, not {every:g}'
        )
    if length < 2.0 * every:
        raise ValueError(f'--window {length:g} s is too short for samples every {every:g} s')
    if length > settings.most_samples * every:
        raise ValueError(f'--window {length:g} s has more than {settings.most_samples} samples')
    return length, every


def simulated(
    kernels: Kernels,
    window: float,
    period: float,
    values: Mapping[str, float],
    amplitudes: Mapping[str, float],
    settings: TrialSettings = TRIAL,
) -> Trial:
    """Roll the model out over a window (s), sampled every `period` s, from its nominal values.

    `values` replaces them by name; an input with an amplitude moves about its value by two cosines.
    Raises ValueError when it does not stay finite.
    """
    model = kernels.model
    t = period * np.arange(round(window / period) + 1)
    x0, u0, p = (
        np.array([values.get(v.name, inside(v)) for v in group], dtype=np.float64)
        for group in (model.states, model.inputs, model.parameters)
    )
    u = np.repeat(u0[None], t.size, axis=0)
    for i, name in enumerate(names(model.inputs)):
        for k, cycles in enumerate(settings.cycles):
            # Later inputs have other cycles, or their effects could not be separated.
            phase = 2.0 * math.pi * (cycles + i * (k + 1)) * t / t[-1]
            u[:, i] += 0.5 * amplitudes.get(name, 0.0) * np.cos(phase)
    for v, value in zip(model.variables, (*x0, *p), strict=True):
        if not v.lower <= value <= v.upper:
            raise ValueError(
                f'{v.name} = {value:g} is outside its bounds {v.lower:g} to {v.upper:g}'
            )
    record = Record(t, u, np.zeros((t.size, len(model.outputs))))
    grid = Grid.of(model, record, np.ones(len(model.outputs)))
    with np.errstate(all='ignore'):
        states, outputs = kernels.trajectories(grid, x0[:, None], p[:, None])
    wrong = ~np.isfinite(np.concatenate([states, outputs], axis=1)).all(axis=(1, 2))
    if wrong.any():
        raise ValueError(
            f'model {quoted(model.name)}: not finite any more {t[wrong.argmax()]:g} s after it was '
            f'started at {_listed(model.variables, (*x0, *p))}: {_remedy(model)}'
        )
    return Trial(Record(t, u, outputs[:, :, 0]), x0, p, states[:, :, 0])


def _remedy(model: Model) -> str:
    if model.period is not None:
        return f'start elsewhere with --value: it gives the next state, {model.period:g} s later'
    return f'shorten max_step ({model.max_step:g} s), or start elsewhere with --value'


def _listed(group: Sequence[Variable], values: Sequence[float]) -> str:
    return ', '.join(f'{v.name} = {value:g}' for v, value in zip(group, values, strict=True))
