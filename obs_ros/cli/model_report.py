"""Report on a model, in lines: variables, trial rollout, speed, and what a window determines."""

import math
import time
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from obs_ros.cli.model_sensors import declared, limited, shown
from obs_ros.cli.model_trial import Trial
from obs_ros.core.model import Model, Variable
from obs_ros.core.periods import lasting_bounds
from obs_ros.core.typing import Array
from obs_ros.inference.assessment.deviations import Deviations
from obs_ros.inference.assessment.identifiability import advice, unseparated, weak_directions
from obs_ros.inference.assessment.informed_subspace import informed_information
from obs_ros.inference.assessment.interval import covariance_without_boxes
from obs_ros.inference.jumps.hypothesis import hypothesis_at
from obs_ros.inference.jumps.piecewise import PiecewiseProblem
from obs_ros.inference.objective import Objective
from obs_ros.inference.parameterisation import Unknowns
from obs_ros.inference.prior import Prior
from obs_ros.integration.backends import Kernels


@dataclass(frozen=True)
class ReportSettings:
    """Assumptions of a report, and the effort of its measurement of speed."""

    noise: float = 0.01  # of an output's standard deviation over the window, where none is given
    candidates: int = 512  # rolled out at once by compiled kernels, an eighth of them by NumPy's
    repeats: int = 5  # of which the fastest counts
    enough: float = 1.0  # s after which no repeat follows


REPORT = ReportSettings()


def variables(model: Model) -> list[str]:
    """Return a line for every variable: unit, bounds, all that is known, sensor or actuator."""
    lines = []
    for kind, group in (
        ('state', model.states),
        ('input', model.inputs),
        ('output', model.outputs),
        ('parameter', model.parameters),
    ):
        for v in group:
            nominal = '' if v.nominal is None else f', nominal {v.nominal:g}'
            free = math.isinf(v.lower) and math.isinf(v.upper)
            bounds = 'no bounds' if free else f'{v.lower:g} to {v.upper:g}'
            if kind == 'output':
                bounds = ''
            elif kind == 'input':
                bounds = v.interpolation
            scale = ', log scale' if v.scale == 'log' else ''
            text = (bounds + scale + nominal + _known(v) + declared(v)).removeprefix(', ')
            lines.append(f'  {kind:9}  {v.name:16} {v.unit:8} {text}'.rstrip())
    return lines


def _known(v: Variable) -> str:
    """Return the words on prior and walk."""
    words = ''
    if v.prior is not None:
        words += f', prior {v.prior[0]:g} (sd {v.prior[1]:g})'
    if v.walk == math.inf:
        words += ', new in every window'
    elif v.walk is not None:
        of, unit = (' of the logarithm', '') if v.scale == 'log' else ('', _unit(v))
        words += f', walk{of} {v.walk:g}{unit}/sqrt(s)'
    return words


def rollout(model: Model, trial: Trial) -> list[str]:
    """Return the trial's inputs and parameters, and the ranges of states and outputs."""
    t, u = trial.record.t, trial.record.u
    kind = '' if model.period is None else f'discrete model, a node every {model.period:g} s; '
    lines = [
        f'{kind}trial rollout: {t[-1]:g} s, a sample every {t[1]:g} s, {trial.steps(model)} steps'
    ]
    for i, variable in enumerate(model.inputs):
        name, low, high = variable.name, u[:, i].min(), u[:, i].max()
        held = f'held at {low:g}; --input {name}=AMPLITUDE moves it'
        text = f'moves within {low:.4g} to {high:.4g}' if high > low else held
        lines.append(f'  input      {name:16} {text}{limited(variable, u[:, i])}')
    lines += [
        f'  parameter  {v.name:16} {value:g}'
        for v, value in zip(model.parameters, trial.p, strict=True)
    ]
    for kind, group, columns in (
        ('state', model.states, trial.states),
        ('output', model.outputs, trial.record.y),
    ):
        for v, column in zip(group, columns.T, strict=True):
            left = ''
            low, high = lasting_bounds(v)
            if kind == 'state' and not (low <= column.min() and column.max() <= high):
                left = f'; it leaves its bounds, {low:g} to {high:g}'
            if kind == 'output':
                left = shown(v, column)
            lines.append(
                f'  {kind:9}  {v.name:16} from {column[0]:.4g} to {column[-1]:.4g}, '
                f'within {column.min():.4g} to {column.max():.4g}{left}'
            )
    return lines


def speed(kernels: Kernels, trial: Trial, settings: ReportSettings = REPORT) -> list[str]:
    """Return the time of a candidate's step, and that of compiling."""
    model = kernels.model
    grid = trial.grid(model)
    prefixes = np.array([grid.t.size])
    lanes = settings.candidates // (1 if kernels.name == 'numba' else 8)
    x0, p = (np.repeat(values[:, None], lanes, axis=1) for values in (trial.x0, trial.p))
    best, begin = math.inf, time.perf_counter()
    for _ in range(settings.repeats):
        start = time.perf_counter()
        kernels.squares(grid, prefixes, x0, p)
        best = min(best, time.perf_counter() - start)
        if time.perf_counter() - begin > settings.enough:
            break
    nanoseconds = 1e9 * best / (lanes * trial.steps(model))
    return [
        f'speed: {nanoseconds:.3g} ns for a step of one candidate, on one core '
        f'({kernels.name}; {kernels.compile_time:.2g} s to compile or load)'
    ]


def identifiable(
    kernels: Kernels,
    trial: Trial,
    noise: Mapping[str, float],
    settings: ReportSettings = REPORT,
) -> list[str]:
    """Return the unknowns with their standard deviations, and what the window leaves open.

    `noise` is the standard deviation of outputs by name; the others get a share of their spread.
    """
    model = kernels.model
    scale, lines = _assumed_noise(model, trial, noise, settings)
    unknowns = Unknowns.of(model)
    objective = Objective(kernels, trial.grid(model, scale), unknowns)
    z = unknowns.point(dict(zip(unknowns.names, (*trial.x0, *trial.p), strict=True)))
    problem = PiecewiseProblem(objective, Prior.known(unknowns, start=True))
    best, n = hypothesis_at(problem, z), unknowns.n_states
    covariance = covariance_without_boxes(best)
    deviations = Deviations.of(best, covariance, 1.0)
    found = (*deviations.initial, *deviations.parameters)
    lines.append(
        f'a window of {trial.record.t[-1]:g} s with every sample tells, of states at its start:'
    )
    kinds = ('state',) * n + ('parameter',) * len(model.parameters)
    values = (*trial.x0, *trial.p)
    for kind, v, value, deviation in zip(kinds, model.variables, values, found, strict=True):
        known = f'known to +- {2.0 * deviation:.2g}{_unit(v)}'
        word = 'not determined' if math.isnan(deviation) else known
        lines.append(f'  {kind:9}  {v.name:16} {value:.4g}, {word}')
    structural = unseparated(objective)
    weak = weak_directions(
        objective, z[n:], informed_information(best), covariance[n:, n:], structural
    )
    lines += [f'  {words}' for words in weak]
    lost = np.flatnonzero(np.isnan(deviations.parameters)) + n
    if lost.size and (words := advice(objective, trial.states[-1], trial.p, lost, structural)):
        lines.append(f'  {words}')
    if not np.isnan(found).any():
        lines.append('  everything is determined (95 % of the true values lie within these limits)')
    return lines


def _assumed_noise(
    model: Model, trial: Trial, noise: Mapping[str, float], settings: ReportSettings
) -> tuple[Array, list[str]]:
    """Return the standard deviation of each output (r,), and the lines that name them."""
    y = trial.record.y
    lines, scale = ['noise assumed (standard deviation):'], np.ones(y.shape[1])
    for i, v in enumerate(model.outputs):
        own = noise.get(v.name)
        spread = float(y[:, i].std())
        scale[i] = math.hypot(own or settings.noise * (spread or 1.0), v.rounding)
        guess = '' if own else f', a guess: give --noise {v.name}=...'
        lines.append(f'  output     {v.name:16} {scale[i]:.3g}{_unit(v)}{guess}')
    return scale, lines


def _unit(variable: Variable) -> str:
    return '' if variable.unit == '1' else f' {variable.unit}'
