"""Tests of obs_ros.inference.assessment.structural: what no input tells apart, and only that."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from obs_ros import Model, Variable
from obs_ros.core.registry import lookup
from obs_ros.inference.assessment.structural import Confounded, confounded
from obs_ros.inference.parameterisation import Unknowns
from obs_ros.integration.vectorised import NumpyKernels
from obs_ros.models import MODELS


def plant(rate: Callable[..., Any], count: int, **changes: Any) -> Model:
    """x' = rate(p, u) - x with parameters p1 ... in (0, 4)."""
    settings: dict[str, Any] = {
        'name': 'combined',
        'states': (Variable('x', lower=-10.0, upper=10.0),),
        'inputs': (Variable('u'),),
        'outputs': (Variable('y'),),
        'parameters': [Variable(f'p{i + 1}', lower=0.0, upper=4.0) for i in range(count)],
        'dynamics': lambda t, x, u, p: (rate(p, u[0]) - x[0],),
        'output': lambda t, x, u, p: (x[0],),
        'max_step': 0.1,
    }
    return Model(**(settings | changes))


def found(model: Model, seconds: float = 6.0, **chosen: Any) -> tuple[Confounded, ...]:
    return confounded(NumpyKernels(model), Unknowns.of(model, **chosen), seconds)


@pytest.mark.parametrize(
    ('rate', 'count', 'quantities'),
    [
        (lambda p, u: p[0] * p[1] * u, 2, ['p1*p2']),
        (lambda p, u: p[0] / p[1] * u, 2, ['p1/p2']),
        (lambda p, u: (p[0] + p[1]) * u, 2, ['p1 + p2']),
        (lambda p, u: (p[0] - 2.0 * p[1]) * u, 2, ['p1 - 2*p2']),
        (lambda p, u: (p[0] + p[1] ** 2) * u, 2, ['']),
        (lambda p, u: p[0] * u + 0.0 * p[1], 2, ['']),
        (lambda p, u: p[0] * p[1] + u / p[2] ** 2 * p[3], 4, ['p3^2/p4', 'p1*p2']),
    ],
)
def test_what_stays_of_two_parameters_is_named(
    rate: Any, count: int, quantities: list[str]
) -> None:
    assert [each.quantity for each in found(plant(rate, count))] == quantities


def test_words_name_the_cure() -> None:
    def words(rate: Any, count: int) -> list[str]:
        return [str(each) for each in found(plant(rate, count))]

    tell = 'no input can tell'
    assert words(lambda p, u: p[0] * p[1] * u, 2) == [
        f'{tell} p1 from p2: fix one, or estimate their product'
    ]
    assert words(lambda p, u: p[0] + p[1] + u, 2) == [
        f'{tell} p1 from p2: fix one, or estimate their sum'
    ]
    assert words(lambda p, u: p[0] / p[1] + u, 2) == [
        f'{tell} p1 from p2: fix one, or estimate p1/p2'
    ]
    assert words(lambda p, u: (p[0] + p[1] * u) * p[2], 3) == [
        f'{tell} p1, p2 and p3 apart: fix one'
    ]
    assert words(lambda p, u: p[0] * u + 0.0 * p[1], 2) == [
        f'{tell} p2, on which no output depends: fix it'
    ]


def test_what_some_input_tells_is_not_named() -> None:
    """With the input at rest the gain has no effect, and the sum is all that is seen."""
    assert found(plant(lambda p, u: p[0] + p[1] * u, 2)) == ()
    assert found(plant(lambda p, u: p[0] * np.maximum(u, 0.0) + p[1] * np.minimum(u, 0.0), 2)) == ()


def test_a_gain_of_an_unknown_state_and_a_fixed_factor() -> None:
    """The scale of what nobody measures stands beside the initial state, which is unknown too."""
    scaled = plant(lambda p, u: p[0] * u, 2, output=lambda t, x, u, p: (p[1] * x[0],))
    assert [each.quantity for each in found(scaled)] == ['p1*p2']
    assert found(scaled, fixed={'p2': 1.0}) == ()
    free = replace(scaled, dynamics=lambda t, x, u, p: (-p[0] * x[0],))
    assert [each.names for each in found(free)] == [('p2',)]


def test_a_model_that_diverges_or_is_too_slow_claims_nothing() -> None:
    product = plant(lambda p, u: p[0] * p[1] * u, 2)
    grows = replace(product, dynamics=lambda t, x, u, p: (np.exp(p[0] * p[1] * (9.0 + x[0] ** 2)),))
    assert found(grows) == ()
    assert found(product, 0.1 * 2001) == ()
    assert found(plant(lambda p, u: u, 0)) == ()


@pytest.mark.parametrize('name', ['jet_engine', 'glycolytic_oscillator', 'linear_second_order'])
def test_models_of_the_package_can_be_told(name: str) -> None:
    model: Any = lookup('model', name, MODELS)
    assert found(model, 100 * min(model.max_step, 0.1)) == ()
