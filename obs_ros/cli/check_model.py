"""Look at a model before it estimates anything: `check_model package.module:MODEL`.

Prints its variables, a trial rollout, how fast it runs, and what a window can tell of its unknowns.
"""

import argparse
import math
import sys
from collections.abc import Callable, Sequence

import numpy as np

from obs_ros.cli.model_kinks import kinks
from obs_ros.cli.model_motion import motion_of
from obs_ros.cli.model_periods import wrapping
from obs_ros.cli.model_proposal import motion_along, proposed, settled_motion
from obs_ros.cli.model_report import (
    identifiable,
    integration,
    rollout,
    speed,
    structure,
    variables,
)
from obs_ros.cli.model_sensors import check_sensors
from obs_ros.cli.model_trial import axis, candidates, simulated
from obs_ros.core.model import names
from obs_ros.core.registry import suggest
from obs_ros.core.texts import one_line, quoted
from obs_ros.models import load_model


def main(arguments: Sequence[str] | None = None) -> int:
    """Check the model named on the command line; 1, with one line on stderr, if it is wrong."""
    options = _options().parse_args(arguments)
    try:
        print('\n'.join(check(options, lambda text: print(text, '...', file=sys.stderr))))
    except ValueError as error:
        print(f'check_model: {one_line(error)}', file=sys.stderr)
        return 1
    return 0


@np.errstate(all='ignore')  # models may overflow: what is not finite says so itself
def check(options: argparse.Namespace, wait_for: Callable[[str], None]) -> list[str]:
    """Return the report on a model; `wait_for` gets words on each step that takes its time.

    Raises ValueError if the model or an option is wrong.
    """
    model = load_model(options.model)
    amplitudes = _by_name('--input', options.input, names(model.inputs))
    values = _by_name('--value', options.value, names((*model.variables, *model.inputs)))
    noise = _by_name('--noise', options.noise, names(model.outputs))
    if any(deviation <= 0.0 for deviation in noise.values()):
        raise ValueError('--noise: a standard deviation must be positive')
    window, period = axis(model, options.window, options.period)  # wrong ones are told at once
    over = motion_of(model, *candidates(model, values))
    title = f'{model.name}: {model.reference}' if model.reference else model.name
    wait_for(f'compiling model {quoted(model.name)}, some seconds the first time, and rolling out')
    if options.window is None:
        wanted = settled_motion(model, over, values, amplitudes, noise).wanted
        window, period = axis(model, None, options.period, wanted)
    check_sensors(model, window)
    trial = simulated(model, window, period, values, amplitudes, noise)
    along = motion_along(trial)
    lines = [title, *variables(model), '', *rollout(model, trial), *wrapping(model, trial), '']
    wait_for('measuring how fast it runs')
    lines += [f'time constants: {along}; over the bounds {over}', *integration(trial)]
    lines += [*kinks(trial, values), *speed(trial), '']
    wait_for('asking what a window tells of every unknown, some seconds the first time')
    lines += [*identifiable(trial), '', *structure(trial)]
    return [*lines, *proposed(model, along, values, noise)]


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
