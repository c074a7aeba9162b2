"""Tests of obs_ros.core.model_kind: what goes with a discrete model, and what does not."""

import math
from dataclasses import replace
from typing import Any

import pytest
from arx import ARX
from plants import LAG

from obs_ros import Model, Variable


def test_the_step_of_a_discrete_model_is_its_period() -> None:
    assert (ARX.period, ARX.max_step, ARX.integrator, ARX.method) == (
        0.1, 0.1, 'discrete', 'discrete'
    )  # fmt: skip
    assert replace(ARX, name='other').period == 0.1
    assert replace(ARX, period=1, max_step=math.inf).max_step == 1.0


@pytest.mark.parametrize(
    ('changes', 'reason'),
    [
        ({'kind': 'sampled'}, "kind 'sampled' is none of continuous, discrete"),
        ({'period': None}, 'give a discrete model its period'),
        ({'period': 'x'}, "period must be a number, not 'x'"),
        ({'period': 0.0, 'max_step': math.inf}, 'period 0.0 s is not within 1e-05 to 1e'),
        ({'period': math.nan}, 'period nan s is not within'),
        ({'max_step': 0.01}, 'leave out max_step, as the step of a discrete model is its period'),
        ({'max_step': -1.0}, 'max_step -1.0 s is not positive'),
        ({'integrator': 'rk4'}, 'leave out integrator, as a discrete model has no rates'),
        (
            {'inputs': (Variable('u', interpolation='linear'),)},
            "let input u have interpolation 'hold'",
        ),
        (
            {'outputs': (Variable('y', delay=(0.0, 0.3)),)},
            'give the delay of y as one number: within 0 to 0.3 s it would be estimated',
        ),
    ],
)
def test_what_does_not_go_with_a_discrete_model_is_refused(
    changes: dict[str, Any], reason: str
) -> None:
    with pytest.raises(ValueError, match=f"^model 'arx': .*{reason}"):
        replace(ARX, **changes)


@pytest.mark.parametrize(
    ('changes', 'reason'),
    [
        ({'period': 0.1}, "leave out period, or say kind='discrete'"),
        ({'integrator': 'discrete'}, "say kind='discrete' and the period"),
        ({'integrator': 'heun'}, "integrator 'heun' is none of auto, rk4"),
    ],
)
def test_what_does_not_go_with_a_continuous_model_is_refused(
    changes: dict[str, Any], reason: str
) -> None:
    with pytest.raises(ValueError, match=reason):
        replace(LAG, **changes)


def test_known_delays_and_walks_go_with_a_discrete_model() -> None:
    late = replace(ARX, outputs=(Variable('y', delay=0.3),), states=[
        replace(v, walk=0.1) for v in ARX.states
    ])  # fmt: skip
    assert isinstance(late, Model)
