"""The report on kinks names the author's line, where it switches and how often that is met."""

import re
from pathlib import Path

import numpy as np

from obs_ros import Model, Variable
from obs_ros.cli.model_kinks import kinks
from obs_ros.cli.model_trial import simulated
from obs_ros.models.three_tank import THREE_TANK


def rubbing(t, x, u, p):
    """A mass that rubs, pulled by a spring."""
    friction = p[0] * np.sign(x[1])
    return x[1], -4.0 * x[0] - friction


def plant(dynamics):
    return Model(
        name='mass',
        states=(
            Variable('s', lower=-2.0, upper=2.0, nominal=1.0), Variable('v', lower=-3.0, upper=3.0)
        ),
        outputs=(Variable('s'),),
        parameters=(Variable('c', lower=0.05, upper=0.2),),
        dynamics=dynamics,
        output=lambda t, x, u, p: (x[0],),
    )  # fmt: skip


def lines(model, window, values=None):
    values = values or {}
    trial = simulated(model, window, window / 100.0, values, {}, {}, backend='numpy')
    return kinks(trial, values)


def test_a_line_that_switches_is_named_with_where_and_how_often():
    (line,) = lines(plant(rubbing), 4.0)
    number = 1 + Path(__file__).read_text()[: Path(__file__).read_text().index('friction =')].count(
        '\n'
    )
    start = f'kink: test_model_kinks.py:{number}: `friction = p[0] * np.sign(x[1])`, where v = 0'
    assert line.startswith(start)
    assert line.endswith('; met in this rollout and 15 of 15 others')


def test_switches_that_no_rollout_meets_are_not_told():
    far = plant(lambda t, x, u, p: (x[1], -4.0 * x[0] - p[0] * np.maximum(x[1], 50.0)))
    assert lines(far, 0.2) == []
    assert lines(plant(lambda t, x, u, p: (x[1], -4.0 * x[0] - p[0] * x[1])), 2.0) == []


def test_a_built_in_model_is_told_once_for_each_line():
    (line,) = lines(THREE_TANK, 300.0, {'h1': 60.0, 'h2': 30.0, 'h3': 65.0})
    assert re.match(r'kink: three_tank.py:\d+: `return np.copysign', line)
    assert 'where h1 - h3 = 0' in line and '; met in this rollout and ' in line
