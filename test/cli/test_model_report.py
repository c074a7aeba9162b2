"""The report on a model: variables, trial, speed, and what a window determines."""

import math
import re
from dataclasses import replace

import numpy as np
import pytest

from obs_ros import Model, Variable
from obs_ros.cli.model_report import (
    ReportSettings,
    identifiable,
    integration,
    rollout,
    speed,
    structure,
    variables,
)
from obs_ros.cli.model_trial import TrialSettings, simulated
from obs_ros.core.prior_knowledge import with_knowledge
from obs_ros.models import load_model

TANKS = load_model('three_tank')


def rolled_out(model=TANKS, values=None, noise=None):
    return simulated(model, 100.0, 1.0, values or {}, {}, noise or {}, backend='numpy')


@pytest.fixture(scope='module')
def trial():
    return rolled_out()


def test_every_variable_has_its_line(trial):
    lines = variables(TANKS)
    order = (*TANKS.states, *TANKS.inputs, *TANKS.outputs, *TANKS.parameters)
    assert [line.split()[1] for line in lines] == [v.name for v in order]
    assert '  state      h1               cm       0 to 100' in lines


def test_the_rollout_names_its_axis_and_the_ranges(trial):
    lines = rollout(TANKS, trial)
    assert lines[0] == 'trial rollout: 100 s, a sample every 1 s, 100 steps'
    assert '  input      Q1               held at 30; --input Q1=AMPLITUDE moves it' in lines
    (h3,) = [line for line in lines if line.startswith('  state      h3 ')]
    end = trial.states[-1, 2]
    assert f'to {end:.4g}, ' in h3


def test_speed_is_that_of_the_fastest_run_and_a_window_is_solved_once(trial):
    (line,) = speed(trial, ReportSettings(candidates=64, repeats=2, patience=0.01))
    (ns,) = re.findall(r'^speed: (\S+) ns for a step of one candidate, .* \(numpy;', line)
    assert 1.0 < float(ns) < 1e7
    assert line.endswith('; a window takes more than 0.01 s from nothing')


def test_method_steps_and_error_are_told(trial):
    (line,) = integration(trial)
    (error,) = re.findall(r'^integration: rk4, 1 step a sample; it errs by (\S+) sta', line)
    assert 0.0 <= float(error) <= 0.1 and line.endswith('of the noise assumed')
    lines = integration(replace(trial, error=0.5, guessed=np.zeros(2, dtype=bool)))
    assert lines[0].startswith('start nearer to where the plant runs with --value')
    assert lines[1].endswith('; it errs by 0.5 standard deviations of the noise')
    assert integration(replace(trial, error=np.inf))[1].endswith('it errs without limit')


def test_parameters_that_no_input_tells_apart_are_told(trial):
    assert structure(trial) == [
        'structure: no parameters were found that every input leaves inseparable'
    ]
    gains = Model(
        name='gains', states=(Variable('x', lower=-5.0, upper=5.0),), inputs=(Variable('u'),),
        outputs=(Variable('x'),),
        parameters=tuple(Variable(name, lower=0.1, upper=2.0) for name in ('a', 'b')),
        dynamics=lambda t, x, u, p: (p[0] * p[1] * (u[0] - x[0]),),
        output=lambda t, x, u, p: (x[0],),
    )  # fmt: skip
    found = simulated(gains, 3.0, 0.1, {}, {}, {}, backend='numpy')
    assert structure(found) == [
        'structure: no input can tell a from b: fix one, or estimate their product'
    ]


def test_twice_the_noise_is_twice_the_deviation():
    start = {'h1': 60.0, 'h2': 30.0, 'h3': 45.0}

    def deviations(scale):
        lines = identifiable(rolled_out(TANKS, start, {'h1': scale, 'h2': scale}))
        return [float(x) for line in lines for x in re.findall(r'known to \+- (\S+)', line)]

    one, two = deviations(1e-4), deviations(2e-4)
    assert len(one) == 6
    assert two == pytest.approx([2.0 * value for value in one], rel=0.06)


def test_noise_that_is_not_given_is_a_guess_from_the_spread():
    settings = TrialSettings(noise=0.1)
    trial = simulated(TANKS, 100.0, 1.0, {}, {}, {'h1': 0.02}, settings, 'numpy')
    lines = identifiable(trial)
    guess = 0.1 * trial.record.y[:, 1].std()
    assert lines[1] == '  output     h1               0.02 cm'
    assert lines[2] == f'  output     h2               {guess:.3g} cm, a guess: give --noise h2=...'


def test_priors_and_walks_stand_beside_the_bounds():
    known = with_knowledge(TANKS, {'h1': 0.2, 'p1': math.inf, 'p2': 0.01}, {'h1': (40.0, 2.0)})
    lines = variables(known)
    for line in (
        '  state      h1               cm       0 to 100, prior 40 (sd 2), walk 0.2 cm/sqrt(s)',
        '  parameter  p1               1        0 to 1, nominal 1, new in every window',
        '  parameter  p2               1        0 to 1, nominal 1, walk 0.01/sqrt(s)',
    ):
        assert line in lines
    log = replace(TANKS, parameters=(
        Variable('p1', 'm', 0.1, 1.0, scale='log', walk=0.1), *TANKS.parameters[1:],
    ))  # fmt: skip
    expected = '  parameter  p1               m        0.1 to 1, log scale, walk of the logarithm'
    assert f'{expected} 0.1/sqrt(s)' in variables(log)


def test_what_is_known_beforehand_makes_more_known():
    """A prior that is as exact as the window halves the variance."""
    noise = {'h1': 0.01, 'h2': 0.01}

    def limit(priors):
        trial = rolled_out(with_knowledge(TANKS, None, priors), None, noise)
        (line,) = (x for x in identifiable(trial) if ' p2 ' in x)
        return float(line.rpartition(' ')[2])

    alone = limit({})
    assert limit({'p2': (0.9, 0.5 * alone)}) == pytest.approx(alone / math.sqrt(2.0), rel=0.02)


def test_sensors_and_actuators_stand_beside_the_rest_and_count(trial):
    half = float(np.median(trial.record.y[:, 0]))
    outputs = (
        replace(TANKS.outputs[0], range=(0.0, half), resolution=0.5), TANKS.outputs[1]
    )  # fmt: skip
    inputs = (replace(TANKS.inputs[0], range=(0.0, 100.0), delay=(0.0, 2.0)), TANKS.inputs[1])
    model = replace(TANKS, inputs=inputs, outputs=outputs)
    lines = variables(model)
    assert (
        '  input      Q1               cm3/s    hold, nominal 30, delay estimated within 0 to 2 s, '
        'range 0 to 100 cm3/s' in lines
    )
    assert (
        f'  output     h1               cm       range 0 to {half:g} cm, resolution 0.5 cm' in lines
    )
    model = replace(TANKS, outputs=outputs)
    (h1,) = [line for line in rollout(model, trial) if line.startswith('  output     h1 ')]
    assert h1.endswith('; its sensor is saturated in 54% of the samples')
    lines = identifiable(rolled_out(model, None, {'h1': 0.02, 'h2': 0.02}))
    assert lines[1] == '  output     h1               0.146 cm'
    assert lines[2] == '  output     h2               0.02 cm'
