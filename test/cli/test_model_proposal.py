"""Windows and sample intervals that are proposed."""

import math
import re

import numpy as np
import pytest

from obs_ros import Model, Variable
from obs_ros.cli.model_motion import motion_of
from obs_ros.cli.model_proposal import proposed, settled_motion
from obs_ros.cli.model_trial import candidates


def decay(name='decay', fast=50.0):
    """A slow state that drains by an unseen fast one, which follows it."""
    return Model(
        name=name,
        states=(
            Variable('slow', lower=0.0, upper=2.0, nominal=1.0),
            Variable('fast', lower=0.0, upper=2.0, nominal=1.0),
        ),
        inputs=(Variable('u', nominal=0.0, lower=-1.0, upper=1.0),),
        outputs=(Variable('slow'),),
        parameters=(Variable('rate', lower=0.05, upper=0.2, nominal=0.1),),
        dynamics=lambda t, x, u, p: (p[0] * (u[0] - x[1]), fast * (x[0] - x[1])),
        output=lambda t, x, u, p: (x[0],),
    )  # fmt: skip


def lines(model):
    over = motion_of(model, *candidates(model, {}))
    along = settled_motion(model, over, {}, {}, {})
    return along, proposed(model, along, {}, {})


def test_the_window_is_that_of_the_slowest_time_constant(monkeypatch):
    monkeypatch.setenv('OBS_ROS_BACKEND', 'numpy')
    along, (line,) = lines(decay())
    assert along.fastest.min() == pytest.approx(0.02, rel=0.01)
    assert along.slowest.max() == pytest.approx(10.0, rel=0.01)
    assert line.startswith('proposed: window.duration 30 s, for the slowest time constant')
    (interval,) = re.findall(r'a sample every (\S+) s or less', line)
    # The slow motion is what tells; samples follow its inputs, not the fast state.
    assert 0.1 <= float(interval) <= 1.0


def test_a_plant_that_only_adds_up_gets_words(monkeypatch):
    monkeypatch.setenv('OBS_ROS_BACKEND', 'numpy')
    integrator = Model(
        name='tank', states=(Variable('level', lower=0.0, upper=1.0),), inputs=(Variable('feed'),),
        outputs=(Variable('level'),), parameters=(Variable('area', lower=0.5, upper=2.0),),
        dynamics=lambda t, x, u, p: (u[0] / p[0],), output=lambda t, x, u, p: (x[0],),
    )  # fmt: skip
    along, (line,) = lines(integrator)
    assert math.isnan(along.wanted) and 'its length is up to them' in line


def test_a_rollout_that_blows_up_is_looked_at_for_a_shorter_time(monkeypatch):
    monkeypatch.setenv('OBS_ROS_BACKEND', 'numpy')
    wild = Model(
        name='wild', states=(Variable('x', lower=0.5, upper=2.0, nominal=1.0),),
        outputs=(Variable('x'),), parameters=(Variable('a', lower=0.1, upper=2.0, nominal=1.0),),
        dynamics=lambda t, x, u, p: (p[0] * x[0] ** 2,), output=lambda t, x, u, p: (x[0],),
    )  # fmt: skip
    along, (line,) = lines(wild)
    assert np.isfinite(along.wanted) and line.startswith('proposed: window.duration ')
