"""Look at a model before it estimates anything: `check_model package.module:MODEL`.

Prints its variables, a trial rollout, how fast it runs, and what a window can tell of its unknowns.
"""

import argparse
import math
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from obs_ros.core.model import Model, Variable, inside, names
from obs_ros.core.record import Record
from obs_ros.core.registry import suggest
from obs_ros.core.texts import one_line, quoted
from obs_ros.core.typing import Array
from obs_ros.inference.assessment.identifiability import advice, weak_directions
from obs_ros.inference.assessment.informed_subspace import InformedSubspace
from obs_ros.inference.assessment.uncertainty import Deviations
from obs_ros.inference.jumps.hypothesis import hypothesis_at
from obs_ros.inference.jumps.piecewise import PiecewiseProblem
from obs_ros.inference.objective import Objective
from obs_ros.inference.parameterisation import Unknowns
from obs_ros.inference.prior import Prior
from obs_ros.integration.backends import Kernels, kernels_for
from obs_ros.integration.grid import Grid
from obs_ros.models import load_model

STEPS = 1000  # in a window, where none is given
SAMPLES = 200  # where the model names no step
MOST_SAMPLES = 1_000_000
NOISE = 0.01  # of an output's standard deviation over the window, where none is given
CYCLES = (3.0, 8.0)  # of the two cosines of a moving input, in the window
LANES, REPEATS, ENOUGH = 512, 5, 1.0  # candidates, runs, s


@dataclass(frozen=True)
class Trial:
    """A window of `record` simulated from x0 (n,) with parameters p (q,), states (K, n)."""

    record: Record
    x0: Array
    p: Array
    states: Array


def main(arguments: Sequence[str] | None = None) -> int:
    """Check the model named on the command line; 1, with one line on stderr, if it is wrong."""
    options = _options().parse_args(arguments)
    try:
        print('\n'.join(check(options, lambda text: print(text, '...', file=sys.stderr))))
    except ValueError as error:
        print(f'check_model: {one_line(error)}', file=sys.stderr)
        return 1
    return 0


def check(options: argparse.Namespace, tell: Callable[[str], None]) -> list[str]:
    """Return what there is to say about a model; `tell` gets what is waited for meanwhile.

    Raises ValueError if the model or an option is wrong.
    """
    model = load_model(options.model)
    window, period = _axis(model, options.window, options.period)
    amplitudes = _by_name('--input', options.input, names(model.inputs))
    values = _by_name('--value', options.value, names((*model.variables, *model.inputs)))
    noise = _by_name('--noise', options.noise, names(model.outputs))
    if any(deviation <= 0.0 for deviation in noise.values()):
        raise ValueError('--noise: a standard deviation must be positive')
    title = f'{model.name}: {model.reference}' if model.reference else model.name
    name, kernels = quoted(model.name), kernels_for(model)
    tell(f'compiling model {name}, some seconds the first time, and rolling out {window:g} s')
    trial = simulated(kernels, window, period, values, amplitudes)
    lines = [title, *variables(model), '', *rollout(model, trial), '']
    tell('measuring how fast it runs')
    lines += [*speed(kernels, trial), '']
    tell('asking what a window tells of every unknown, some seconds the first time')
    return [*lines, *identifiable(kernels, trial, noise)]


def simulated(
    kernels: Kernels,
    window: float,
    period: float,
    values: dict[str, float],
    amplitudes: dict[str, float],
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
        for k, cycles in enumerate(CYCLES):
            # Later inputs have other cycles, or one could not be told from the next.
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
            f'started at {_listed(model.variables, (*x0, *p))}: shorten max_step '
            f'({model.max_step:g} s), or start elsewhere with --value'
        )
    return Trial(Record(t, u, outputs[:, :, 0]), x0, p, states[:, :, 0])


def variables(model: Model) -> list[str]:
    """Return a line for every variable: unit, bounds, nominal value."""
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
            text = (bounds + scale + nominal).removeprefix(', ')
            lines.append(f'  {kind:9}  {v.name:16} {v.unit:8} {text}'.rstrip())
    return lines


def rollout(model: Model, trial: Trial) -> list[str]:
    """Return where the states and outputs go."""
    t, u = trial.record.t, trial.record.u
    lines = [f'trial rollout: {t[-1]:g} s, a sample every {t[1]:g} s, {_steps(model, trial)} steps']
    for i, variable in enumerate(model.inputs):
        name, low, high = variable.name, u[:, i].min(), u[:, i].max()
        held = f'held at {low:g}; --input {name}=AMPLITUDE moves it'
        text = f'moves within {low:.4g} to {high:.4g}' if high > low else held
        lines.append(f'  input      {name:16} {text}')
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
            if kind == 'state' and not (v.lower <= column.min() and column.max() <= v.upper):
                left = f'; it leaves its bounds, {v.lower:g} to {v.upper:g}'
            lines.append(
                f'  {kind:9}  {v.name:16} from {column[0]:.4g} to {column[-1]:.4g}, '
                f'within {column.min():.4g} to {column.max():.4g}{left}'
            )
    return lines


def speed(kernels: Kernels, trial: Trial) -> list[str]:
    """Return how long compiling took, and a candidate's step."""
    model = kernels.model
    grid = Grid.of(model, trial.record, np.ones(len(model.outputs)))
    prefixes = np.array([grid.t.size])
    lanes = LANES if kernels.name == 'numba' else LANES // 8
    x0, p = (np.repeat(values[:, None], lanes, axis=1) for values in (trial.x0, trial.p))
    best, begin = math.inf, time.perf_counter()
    for _ in range(REPEATS):
        start = time.perf_counter()
        kernels.squares(grid, prefixes, x0, p)
        best = min(best, time.perf_counter() - start)
        if time.perf_counter() - begin > ENOUGH:
            break
    nanoseconds = 1e9 * best / (lanes * _steps(model, trial))
    return [
        f'speed: {nanoseconds:.3g} ns for a step of one candidate, on one core '
        f'({kernels.name}; {kernels.compile_time:.2g} s to compile or load)'
    ]


def identifiable(kernels: Kernels, trial: Trial, noise: dict[str, float]) -> list[str]:
    """Return what the window tells of every unknown, and what it does not tell."""
    model, y = kernels.model, trial.record.y
    lines, scale = ['noise assumed (standard deviation):'], np.ones(y.shape[1])
    for i, v in enumerate(model.outputs):
        own = noise.get(v.name)
        spread = float(y[:, i].std())
        scale[i] = own or NOISE * (spread or 1.0)
        how = '' if own else f', a guess: give --noise {v.name}=...'
        lines.append(f'  output     {v.name:16} {scale[i]:.3g}{_unit(v)}{how}')
    unknowns = Unknowns.of(model)
    objective = Objective(kernels, Grid.of(model, trial.record, scale), unknowns)
    z = unknowns.point(dict(zip(unknowns.names, (*trial.x0, *trial.p), strict=True)))
    prior = Prior.box(unknowns)
    best = hypothesis_at(PiecewiseProblem(objective, prior), z)
    gate, n = InformedSubspace.of(best), unknowns.n_states
    covariance = gate.covariance(best)
    deviations = Deviations.of(best, covariance, 1.0)
    found = (*deviations.initial, *deviations.parameters)
    lines.append(
        f'a window of {trial.record.t[-1]:g} s with every sample tells, of states at its start:'
    )
    for kind, v, value, deviation in zip(
        ('state',) * n + ('parameter',) * len(model.parameters),
        model.variables, (*trial.x0, *trial.p), found, strict=True,
    ):  # fmt: skip
        word = (
            'not determined'
            if math.isnan(deviation)
            else f'known to +- {2.0 * deviation:.2g}{_unit(v)}'
        )
        lines.append(f'  {kind:9}  {v.name:16} {value:.4g}, {word}')
    lines += [
        f'  {words}'
        for words in weak_directions(objective, z[n:], gate.information, covariance[n:, n:])
    ]
    lost = np.flatnonzero(np.isnan(deviations.parameters)) + n
    if lost.size and (words := advice(objective, trial.states[-1], trial.p, lost)):
        lines.append(f'  {words}')
    if not np.isnan(found).any():
        lines.append('  everything is determined (95 % of the true values lie within these limits)')
    return lines


def _steps(model: Model, trial: Trial) -> int:
    return int(Grid.of(model, trial.record, np.ones(len(model.outputs))).steps.sum())


def _axis(model: Model, window: float | None, period: float | None) -> tuple[float, float]:
    """Return the length of the window and the sample period, both in s."""
    step = model.max_step
    length = window or (STEPS * step if math.isfinite(step) else 10.0)
    every = period or (step if math.isfinite(step) else length / SAMPLES)
    for name, value in (('--window', length), ('--period', every)):
        if not (math.isfinite(value) and value > 0.0):
            raise ValueError(f'{name} must be a positive time in s, not {value}')
    if length < 2.0 * every:
        raise ValueError(f'--window {length:g} s is too short for samples every {every:g} s')
    if length > MOST_SAMPLES * every:
        raise ValueError(f'--window {length:g} s has more than {MOST_SAMPLES} samples')
    return length, every


def _by_name(option: str, given: Sequence[str], known: tuple[str, ...]) -> dict[str, float]:
    found = {}
    for text in given:
        name, _, value = text.partition('=')
        if name not in known:
            raise ValueError(f'{option}: there is no {quoted(name)}: {suggest(name, known)}')
        try:
            found[name] = float(value)
        except ValueError:
            raise ValueError(f'{option} must be {name}=NUMBER, not {quoted(text)}') from None
        if not math.isfinite(found[name]):
            raise ValueError(f'{option} {text}: the number must be finite')
    return found


def _listed(group: Sequence[Variable], values: Sequence[float]) -> str:
    return ', '.join(f'{v.name} = {value:g}' for v, value in zip(group, values, strict=True))


def _unit(variable: Variable) -> str:
    return '' if variable.unit == '1' else f' {variable.unit}'


def _options() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog='check_model', description=__doc__)
    parser.add_argument('model', help='a built-in name or package.module:ATTRIBUTE')
    parser.add_argument('--window', type=float, help='length of the window, in s')
    parser.add_argument('--period', type=float, help='from one sample to the next, in s')
    for option, metavar, text in (
        ('noise', 'OUTPUT=SD', 'standard deviation of a measured output, in its unit'),
        ('input', 'INPUT=AMPLITUDE', 'move an input about its nominal value, in its unit'),
        ('value', 'NAME=VALUE', 'of a state at the start, a parameter or an input, not nominal'),
    ):
        parser.add_argument(f'--{option}', action='append', default=[], metavar=metavar, help=text)
    return parser


if __name__ == '__main__':
    sys.exit(main())
