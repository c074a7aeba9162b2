"""The report on periods: the model must be the same one period on."""

from typing import Any

import numpy as np
import pytest
from spinner import SHAFT, TURN

from obs_ros import Model, Variable
from obs_ros.cli.model_periods import wrapping
from obs_ros.cli.model_trial import simulated


def pendulum(torque: Any, output: Any = lambda t, x, u, p: (x[0],)) -> Model:
    """angle'' = torque of the angle, from 1 rad."""
    return Model(
        'pendulum',
        states=(
            Variable('angle', 'rad', -np.pi, np.pi, nominal=1.0, period=TURN),
            Variable('rate', 'rad/s', -9.0, 9.0),
        ),
        outputs=(Variable('sensor', 'rad', period=TURN),),
        dynamics=lambda t, x, u, p: (x[1], torque(x[0])), output=output, max_step=0.05,
    )  # fmt: skip


def lines(model: Model) -> list[str]:
    return wrapping(model, simulated(model, 2.0, 0.05, {}, {}, {}, backend='numpy'))


@pytest.mark.parametrize('model', [SHAFT, pendulum(lambda angle: -9.81 * np.sin(angle))])
def test_a_model_with_its_period_passes(model: Model) -> None:
    assert lines(model) == []


def test_dynamics_that_count_turns_are_told() -> None:
    (line,) = lines(pendulum(lambda angle: -9.81 * angle))
    assert line.startswith('  give state angle no period, or write the model with its sine')
    assert "a period of 6.28319 on, rate' differ" in line


def test_outputs_that_count_turns_are_told_unless_whole_turns_apart() -> None:
    geared = pendulum(lambda angle: -np.sin(angle), lambda t, x, u, p: (0.5 * x[0],))
    assert 'sensor differ' in lines(geared)[0]
    assert lines(pendulum(lambda angle: -np.sin(angle), lambda t, x, u, p: (3.0 * x[0],))) == []


@pytest.mark.parametrize(('gain', 'told'), [(1.0, 0), (0.9, 1)])
def test_the_next_state_is_as_many_periods_on(gain: float, told: int) -> None:
    wheel = Model(
        'wheel', states=(Variable('angle', period=TURN, nominal=1.0), Variable('speed', '1', 0, 1)),
        outputs=(Variable('sensor', period=TURN),), output=lambda t, x, u, p: (x[0],),
        dynamics=lambda t, x, u, p: (gain * x[0] + x[1], x[1]), kind='discrete', period=0.05,
    )  # fmt: skip
    found = lines(wheel)
    assert len(found) == told
    assert all('angle of the next node differ' in line for line in found)
