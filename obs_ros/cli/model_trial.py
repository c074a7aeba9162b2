"""A trial rollout of a model, from its nominal values over one window."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from obs_ros.cli.model_steps import integrated
from obs_ros.core.estimated_delays import is_delay
from obs_ros.core.model import Model, Variable, inside, names
from obs_ros.core.record import Record
from obs_ros.core.rng import random_generator
from obs_ros.core.texts import quoted
from obs_ros.core.typing import Array, BoolArray, IntArray
from obs_ros.inference.parameterisation import Unknowns
from obs_ros.integration.backends import Backend, Kernels
from obs_ros.integration.grid import Grid


@dataclass(frozen=True)
class TrialSettings:
    """The window of a trial, where the user does not give it."""

    steps: int = 1000  # of the model, in a window, where it has a step but no time constants
    duration: float = 10.0  # s of a window, where the model has no time constants
    samples: int = 200  # in a window, where the model names no step
    most_samples: int = 1_000_000  # 8 MB for each variable
    cycles: tuple[float, float] = (3.0, 8.0)  # of a moving input's two cosines, in the window
    candidates: int = 16  # the nominal one first; the others lie anywhere in the boxes
    largest: float = 1e100  # of what a state may be
    lost: float = 0.1  # of a state's range along the window, by which it may err
    noise: float = 0.01  # of an output's standard deviation, where none is given


TRIAL = TrialSettings()


@dataclass(frozen=True)
class Trial:
    """A window of `record` simulated from x0 (n,) with parameters p (q,), states (K, n).

    By `kernels` in the steps of the grid `chosen`, which err by `error` standard deviations of the
    noise `scale` (r,) at most; `guessed` (r,) tells where that is not given.
    """

    record: Record
    x0: Array
    p: Array
    states: Array
    kernels: Kernels
    chosen: Grid
    error: float
    scale: Array
    guessed: BoolArray

    @property
    def model(self) -> Model:
        """The plant, as it is integrated."""
        return self.kernels.model

    @property
    def grid(self) -> Grid:
        """The window's grid."""
        return Grid.of(self.model, self.record, self.scale).like(self.chosen)

    @property
    def step_counts(self) -> IntArray:
        """The steps (K - 1,) from node to node."""
        return self.chosen.steps

    @property
    def own_parameters(self) -> int:
        """The number of parameters that the model's functions take: delays are none of them."""
        return sum(not is_delay(v.name) for v in self.model.parameters)

    @property
    def steps(self) -> int:
        """The number of steps over the window."""
        return int(self.step_counts.sum())


def axis(
    model: Model,
    window: float | None = None,
    period: float | None = None,
    wanted: float = math.nan,
    settings: TrialSettings = TRIAL,
) -> tuple[float, float]:
    """Return the length of the window and the sample period (s), given or from the model.

    `wanted` is the length that the model's time constants ask for. Raises ValueError for a window
    with fewer than three samples or too many.
    """
    step = model.max_step
    free = math.isinf(step)
    usual = settings.duration if free else settings.steps * step
    length = window or (wanted if math.isfinite(wanted) else usual)
    every = period or (length / settings.samples if free else step)
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


def candidates(
    model: Model, values: Mapping[str, float], settings: TrialSettings = TRIAL
) -> tuple[Array, Array]:
    """Return states x0 (n, B) and parameters p (q, B): nominal ones, then some from the boxes.

    `values` replaces nominal ones by name. Raises ValueError for one outside its bounds.
    """
    for v in model.variables:
        value = values.get(v.name, inside(v))
        if not v.lower <= value <= v.upper:
            raise ValueError(
                f'{v.name} = {value:g} is outside its bounds {v.lower:g} to {v.upper:g}'
            )
    unknowns = Unknowns.of(model)
    rng = random_generator(0)
    count = settings.candidates
    order = np.argsort(rng.random((unknowns.dimension, count)), axis=1)
    x0, p = unknowns.values((order.T + 0.5) / count)  # a Latin hypercube
    for group, columns in ((model.states, x0), (model.parameters, p)):
        columns[:, 0] = [values.get(v.name, inside(v)) for v in group]
    return x0, p


def simulated(
    model: Model,
    window: float,
    period: float,
    values: Mapping[str, float],
    amplitudes: Mapping[str, float],
    noise: Mapping[str, float],
    settings: TrialSettings = TRIAL,
    backend: Backend | None = None,
) -> Trial:
    """Roll the model out over a window (s), sampled every `period` s, from its nominal values.

    `values` replaces them by name; an input with an amplitude moves about its value by two cosines.
    `noise` is the standard deviation of outputs by name; others get a share of their spread.
    Raises ValueError when no steps follow it.
    """
    x0, p = candidates(model, values, settings)
    if model.period is not None:
        period = max(1, round(period / model.period)) * model.period
    t = period * np.arange(round(window / period) + 1)
    u = np.repeat([[values.get(v.name, inside(v)) for v in model.inputs]], t.size, axis=0)
    for i, name in enumerate(names(model.inputs)):
        for k, cycles in enumerate(settings.cycles):
            # Later inputs have other cycles, or their effects could not be separated.
            phase = 2.0 * math.pi * (cycles + i * (k + 1)) * t / t[-1]
            u[:, i] += 0.5 * amplitudes.get(name, 0.0) * np.cos(phase)
    record = Record(t, u, np.zeros((t.size, len(model.outputs))))
    with np.errstate(all='ignore'):
        y = np.array([
            np.broadcast_to(each, x0.shape[1])
            for each in model.output(np.float64(0.0), tuple(x0), tuple(u[0]), tuple(p))
        ])  # fmt: skip
    # How far outputs spread along the window only rollouts tell, whose steps depend on it.
    scale = _noise(model, noise, y, settings)
    for _ in range(2):
        kernels, chosen, error = integrated(model, record, scale, x0[:, 0], p[:, 0], backend)
        states, outputs, wrong = _followed(kernels, record, scale, chosen, x0[:, :1], p[:, :1])
        if wrong.any():
            at = _listed(model.variables, (*x0[:, 0], *p[:, 0]))
            raise ValueError(
                f'start elsewhere with --value, shorten --window{_remedy(model)}: no steps follow '
                f'model {quoted(model.name)} beyond {t[wrong.argmax()]:g} s after it was started '
                f'at {at}'
            )
        used, scale = scale, _noise(model, noise, outputs[:, :, 0].T, settings)
        if (scale >= used).all():
            break
    guessed = np.array([v.name not in noise for v in model.outputs])
    record = Record(t, u, outputs[:, :, 0])
    return Trial(record, x0[:, 0], p[:, 0], states[:, :, 0], kernels, chosen, error, scale, guessed)


def _followed(
    kernels: Kernels, record: Record, scale: Array, chosen: Grid, x0: Array, p: Array
) -> tuple[Array, Array, BoolArray]:
    """Return states (K, n, 1) and outputs (K, r, 1), and the nodes (K,) where they are wrong.

    Finer steps show outputs elsewhere there, by more than the noise, or states elsewhere in
    their range; or they are no numbers of any plant.
    """
    grid = Grid.of(kernels.model, record, scale).like(chosen)
    with np.errstate(all='ignore'):
        states, outputs = kernels.trajectories(grid, x0, p)
        finer = grid if kernels.model.period is not None else grid.finer()
        others = kernels.trajectories(finer, x0, p)
        size = TRIAL.lost * np.ptp(others[0], axis=0)
        right = np.abs(states - others[0]) <= np.where(size < TRIAL.largest, size, 0.0)
        shown = np.abs(outputs - others[1]) <= scale[:, None]
        right &= np.abs(states) < TRIAL.largest
        followed = right.all(axis=(1, 2)) & shown.all(axis=(1, 2))
        return states, outputs, np.asarray(~followed)


def _noise(model: Model, noise: Mapping[str, float], y: Array, settings: TrialSettings) -> Array:
    """Return the standard deviations (r,) of the outputs, given or a share of y's (r, any)."""
    scale = np.ones(len(y))
    for i, v in enumerate(model.outputs):
        known = y[i][np.isfinite(y[i])]
        spread = float(known.std()) if known.size else 0.0
        scale[i] = math.hypot(noise.get(v.name) or settings.noise * (spread or 1.0), v.rounding)
    return scale


def _remedy(model: Model) -> str:
    if model.period is not None:
        return f', or mend dynamics, which give the next state, {model.period:g} s later'
    return ', or give the model a max_step'


def _listed(group: Sequence[Variable], values: Sequence[float]) -> str:
    return ', '.join(f'{v.name} = {value:g}' for v, value in zip(group, values, strict=True))
