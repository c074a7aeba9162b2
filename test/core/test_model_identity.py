"""Tests of obs_ros.core.model_identity."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from obs_ros import Model, Variable
from obs_ros.core.model_identity import SAME, Identity, behaviour, declared, difference
from obs_ros.models import MODELS, load_model

RATE = 0.3


def cooling(t: Any, x: Any, u: Any, p: Any) -> tuple[Any]:
    return (-p[0] * (x[0] - u[0]),)


def cooling_again(time: Any, state: Any, given: Any, par: Any) -> tuple[Any]:
    (warm,), (outside,), (loss,) = state, given, par
    return (loss * outside - loss * warm,)


def slower(t: Any, x: Any, u: Any, p: Any) -> tuple[Any]:
    return (-0.99 * p[0] * (x[0] - u[0]),)


def kelvin(t: Any, x: Any, u: Any, p: Any) -> tuple[Any]:
    return (x[0] + 273.15,)


def model(**changes: Any) -> Model:
    fields: dict[str, Any] = {
        'name': 'cooling',
        'states': (Variable('T', 'degC', lower=0.0, upper=90.0),),
        'inputs': (Variable('T_out', 'degC'),),
        'outputs': (Variable('y', 'K'),),
        'parameters': (Variable('loss', '1/s', lower=0.0, upper=1.0),),
        'dynamics': cooling,
        'output': kelvin,
    }
    return Model(**{**fields, **changes})


def identity(of: Model) -> Identity:
    return Identity(declared(of), behaviour(of))


def test_it_is_the_same_however_the_equations_are_written() -> None:
    assert difference(identity(model()), identity(model(dynamics=cooling_again))) == ''


@pytest.mark.parametrize(
    ('changes', 'said'),
    [
        ({'dynamics': slower}, 'the equations are others: entry 0'),
        ({'output': lambda t, x, u, p: (x[0] + 273.0,)}, 'the equations are others: entry 1'),
        ({'name': 'heating'}, "name was \"'cooling'\", and is \"'heating'\""),
        ({'states': (Variable('T', 'degC', lower=0.0, upper=80.0),)},
         "upper of state T was '90.0', and is '80.0'"),
        ({'states': (Variable('T', 'K', lower=0.0, upper=90.0),)},
         "unit of state T was \"'degC'\""),
        ({'states': (Variable('T', 'degC', lower=0.0, upper=90.0, prior=(20.0, 5.0)),)},
         'prior of state T was none, and is '),
        ({'parameters': (Variable('loss', '1/s', lower=0.0, upper=1.0, walk=0.1),)},
         'walk of parameter loss was none'),
        ({'outputs': (Variable('y', 'K', resolution=0.1),)}, 'resolution of output y'),
        ({'inputs': (Variable('out', 'degC'),)}, "inputs was 'T_out', and is 'out'"),
    ],
)  # fmt: skip
def test_what_makes_another_plant_of_it(changes: dict[str, Any], said: str) -> None:
    found = difference(identity(model()), identity(model(**changes)))
    assert found.startswith(said)
    assert difference(identity(model(**changes)), identity(model()))


def test_what_is_only_a_way_to_compute_it_does_not_count() -> None:
    other = model(max_step=0.1, integrator='euler', reference='a book')
    assert difference(identity(model()), identity(other)) == ''


def test_last_bits_do_not_count() -> None:
    one = identity(model())
    near = replace(one, behaviour=one.behaviour * (1.0 + 0.5 * SAME))
    far = replace(one, behaviour=one.behaviour * (1.0 + 2.0 * SAME))
    assert difference(near, one) == ''
    assert difference(far, one)
    assert 'number of entries' in difference(replace(one, behaviour=one.behaviour[:, :1]), one)


@pytest.mark.parametrize('name', list(MODELS))
def test_every_model_behaves_at_its_points(name: str) -> None:
    found = behaviour(load_model(name))
    assert np.isfinite(found).any(axis=0).all()
    assert difference(identity(load_model(name)), identity(load_model(name))) == ''
