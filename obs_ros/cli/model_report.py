"""Report on a model, in lines: variables, trial rollout, speed, and what a window determines."""

import math
import time
from dataclasses import dataclass
from typing import cast

import numpy as np

from obs_ros.cli.model_sensors import declared, limited, shown
from obs_ros.cli.model_trial import Trial
from obs_ros.core.deadline import Deadline
from obs_ros.core.estimate import Outcome
from obs_ros.core.model import Model, Variable, names
from obs_ros.core.periods import lasting_bounds
from obs_ros.core.rng import random_generator
from obs_ros.horizon.settings import EstimationSettings
from obs_ros.horizon.solver import Solver
from obs_ros.inference.assessment.deviations import Deviations
from obs_ros.inference.assessment.identifiability import advice, unseparated, weak_directions
from obs_ros.inference.assessment.informed_subspace import informed_information
from obs_ros.inference.assessment.interval import covariance_without_boxes
from obs_ros.inference.jumps.hypothesis import hypothesis_at
from obs_ros.inference.jumps.piecewise import PiecewiseProblem
from obs_ros.inference.objective import Objective
from obs_ros.inference.parameterisation import Unknowns
from obs_ros.inference.prior import Prior
from obs_ros.integration.backends import Backend
from obs_ros.integration.step_trials import STEPPING


@dataclass(frozen=True)
class ReportSettings:
    """The effort of a report's measurement of speed."""

    candidates: int = 512  # rolled out at once by compiled kernels, an eighth of them by NumPy's
    repeats: int = 5  # of which the fastest counts
    enough: float = 1.0  # s after which no repeat follows
    patience: float = 3.0  # s for solving the trial's window once


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
    lines = [f'{kind}trial rollout: {t[-1]:g} s, a sample every {t[1]:g} s, {trial.steps} steps']
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


def integration(trial: Trial) -> list[str]:
    """Return the method and its steps, and how far they err; nothing of a discrete model."""
    if trial.model.period is not None:
        return []
    counts = trial.step_counts
    most = f' to {counts.max()}' if counts.max() > counts.min() else ''
    steps = 'step' if counts.max() == 1 else 'steps'
    noise = 'the noise assumed' if trial.guessed.any() else 'the noise'
    said = f'integration: {trial.model.method}, {counts.min()}{most} {steps} a sample'
    if trial.error <= STEPPING.tolerated:
        return [f'{said}; it errs by {trial.error:.2g} standard deviations of {noise}']
    size = f'by {trial.error:.2g} standard deviations of {noise}'
    return [
        'start nearer to where the plant runs with --value, or shorten --window: no steps were '
        'found that are fine enough, and what follows may be wrong',
        f'{said}; it errs {size if math.isfinite(trial.error) else "without limit"}',
    ]


def speed(trial: Trial, settings: ReportSettings = REPORT) -> list[str]:
    """Return the time of a candidate's step and of a window, and that of compiling."""
    kernels, grid = trial.kernels, trial.grid
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
    nanoseconds = 1e9 * best / (lanes * trial.steps)
    return [
        f'speed: {nanoseconds:.3g} ns for a step of one candidate, on one core '
        f'({kernels.name}; {kernels.compile_time:.2g} s to compile or load); '
        + _window_time(trial, settings)
    ]


def _window_time(trial: Trial, settings: ReportSettings) -> str:
    """Return how long solving the trial's window takes, from nothing."""
    model, record = trial.model, trial.record
    noise = dict(zip(names(model.outputs), trial.scale.tolist(), strict=True))
    y = record.y + trial.scale * random_generator(0).standard_normal(record.y.shape)
    options = EstimationSettings(
        noise=noise, process_noise='off', backend=cast(Backend, trial.kernels.name)
    )
    solver = Solver.of(model, options)
    solver.prepare()
    estimate = solver.solve(
        record.with_outputs(y), random_generator(0), Deadline(settings.patience)
    )
    if estimate.outcome is Outcome.DEADLINE:
        return f'a window takes more than {settings.patience:g} s from nothing'
    return f'a window takes {estimate.solve_time:.2g} s from nothing'


def structure(trial: Trial) -> list[str]:
    """Return what no input can tell of the parameters, whatever the window."""
    objective = Objective(trial.kernels, trial.grid, Unknowns.of(trial.model))
    found = unseparated(objective)
    if not found:
        return ['structure: no parameters were found that every input leaves inseparable']
    return [f'structure: {each}' for each in found]


def identifiable(trial: Trial) -> list[str]:
    """Return the unknowns with their standard deviations, and what the window leaves open."""
    model, lines = trial.model, ['noise assumed (standard deviation):']
    for v, scale, guessed in zip(model.outputs, trial.scale, trial.guessed, strict=True):
        guess = f', a guess: give --noise {v.name}=...' if guessed else ''
        lines.append(f'  output     {v.name:16} {scale:.3g}{_unit(v)}{guess}')
    unknowns = Unknowns.of(model)
    objective = Objective(trial.kernels, trial.grid, unknowns)
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


def _unit(variable: Variable) -> str:
    return '' if variable.unit == '1' else f' {variable.unit}'
