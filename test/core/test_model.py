"""Tests of obs_ros.core.model."""

import functools
import math
import re
from dataclasses import FrozenInstanceError, replace
from types import FunctionType
from typing import Any

import numpy as np
import pytest

from obs_ros import Model, Variable
from obs_ros.core.model import checked_noise, inside, names
from obs_ros.models.three_tank import THREE_TANK

INF = math.inf


def plant(**changes: Any) -> Model:
    settings: dict[str, Any] = {
        'name': 'plant',
        'states': [Variable('x', lower=0.0, upper=4.0)],
        'outputs': [Variable('y')],
        'inputs': [Variable('u')],
        'parameters': [Variable('a'), Variable('b')],
        'dynamics': lambda t, x, u, p: (-p[0] * x[0] + u[0],),
        'output': lambda t, x, u, p: (p[1] * x[0],),
    }
    return Model(**(settings | changes))


def test_a_model_is_immutable_hashable_and_keeps_order() -> None:
    model = plant()
    assert model.states == (Variable('x', lower=0.0, upper=4.0),)
    assert names(model.variables) == ('x', 'a', 'b')
    assert hash(model) == hash(replace(model))
    assert model == replace(model)
    assert model != replace(model, max_step=2.0)
    with pytest.raises(FrozenInstanceError):
        model.max_step = 1.0  # type: ignore[misc]


def test_variables_are_found_by_name_with_a_hint() -> None:
    assert plant().variable('b').name == 'b'
    with pytest.raises(
        ValueError, match=r"'plant' has no state or parameter 'u': known are a, b, x"
    ):
        plant().variable('u')


def test_sensors_and_actuators_are_declared_in_floats() -> None:
    variable = Variable('v', period=6, range=[0, 10], resolution=1, delay=(0, 1))
    assert (variable.period, variable.range, variable.resolution) == (6.0, (0.0, 10.0), 1.0)
    assert variable.delay == (0.0, 1.0) and Variable('v', delay=-1).delay == -1.0
    assert Variable('v', range=(0.0, INF)).range == (0.0, INF)
    model = plant(
        states=[Variable('x', period=360.0)],
        inputs=[Variable('u', range=(0.0, 1.0), delay=0.1)],
        outputs=[Variable('y', period=360.0, range=(0.0, 1.0), resolution=0.1, delay=0.2)],
    )
    assert model.outputs[0].resolution == 0.1
    with pytest.raises(TypeError):
        Variable('v', '1', 0.0, 1.0, None, 'hold', None, 'linear', None, 'none', 1.0)  # type: ignore[misc]


@pytest.mark.parametrize(
    ('changes', 'message'),
    [
        ({'name': 'h 1'}, "'h 1' is not an identifier"),
        ({'lower': 2.0, 'upper': 1.0}, 'v: lower bound 2.0 is not below upper bound 1.0'),
        ({'lower': 1.0, 'upper': 1.0}, 'v: lower bound 1.0 is not below upper bound 1.0'),
        ({'lower': math.nan}, 'v: lower bound nan is not below'),
        ({'upper': math.nan}, 'is not below upper bound nan'),
        ({'lower': 0.0, 'upper': 1.0, 'nominal': 1.5}, 'v: nominal 1.5 is outside [0.0, 1.0]'),
        ({'nominal': math.nan}, 'v: nominal nan is outside [-inf, inf]'),
        ({'period': 0.0}, 'v: period 0.0 is not positive and finite'),
        ({'resolution': -1}, 'v: resolution -1.0 is not positive and finite'),
        ({'resolution': math.nan}, 'v: resolution nan is not positive and finite'),
        ({'resolution': '1'}, "v: resolution must be a number, not '1'"),
        ({'range': (1.0, 1.0)}, 'v: the low end 1.0 of its range is not below the high end 1.0'),
        ({'range': (0.0, math.nan)}, 'v: the low end 0.0 of its range is not below'),
        ({'range': (-INF, INF)}, 'v: leave the range out, as -inf to inf limits nothing'),
        ({'range': 10.0}, 'v: range must be (low, high), not 10.0'),
        ({'delay': math.inf}, 'v: delay inf s is not within +-1e+06 s'),
        ({'delay': (0.0, math.nan)}, 'v: delay nan s is not within'),
        ({'delay': (0.5, 0.1)}, 'v: delay from 0.5 s is not below its upper bound 0.1 s'),
        ({'delay': (0.1,)}, 'v: delay must be a time in s, or (lower, upper) to estimate it'),
        ({'interpolation': 'spline'}, "v: interpolation 'spline' is none of hold, linear, mean"),
    ],
)
def test_a_wrong_variable_is_refused_by_name(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=re.escape(message)):
        Variable(**({'name': 'v'} | changes))


@pytest.mark.parametrize(
    ('changes', 'message'),
    [
        ({'states': []}, "'plant' needs at least one state and one output"),
        ({'outputs': []}, "'plant' needs at least one state and one output"),
        ({'parameters': [Variable('x'), Variable('b')]}, "more than one variable 'x'"),
        ({'outputs': [Variable('y'), Variable('y')]}, "more than one variable 'y'"),
        ({'inputs': [Variable('u'), Variable('u')]}, "more than one variable 'u'"),
        (
            {'inputs': [Variable('u', resolution=1.0)]},
            "'plant': u is one of the inputs, but only outputs have a resolution",
        ),
        (
            {'inputs': [Variable('u', period=1.0)]},
            'u is one of the inputs, but only states and outputs have a period',
        ),
        ({'states': [Variable('x', range=(0, 1))]}, 'only inputs and outputs have a range'),
        ({'parameters': [Variable('a', delay=1.0), Variable('b')]}, 'a is one of the parameters'),
        ({'max_step': 0.0}, 'max_step 0.0 s is not positive'),
        ({'max_step': math.nan}, 'max_step nan s is not positive'),
        ({'integrator': 'heun'}, "integrator 'heun' is none of auto, rk4, euler"),
        ({'dynamics': lambda t, x, u, p: (1.0, 2.0)}, 'must return a tuple of 1 entries'),
        (
            {'output': lambda t, x, u, p: x[0]},
            'must return a tuple of 1 entries, one number',
        ),
    ],
)
def test_a_wrong_model_is_refused_with_the_reason(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=re.escape(message)):
        plant(**changes)


def decay(t: Any, x: Any, u: Any, p: Any, k: float = 1.0) -> Any:
    return (-k * p[0] * x[0],)


class Decay:
    def __call__(self, t: Any, x: Any, u: Any, p: Any) -> Any:
        return decay(t, x, u, p)

    def method(self, t: Any, x: Any, u: Any, p: Any) -> Any:
        return decay(t, x, u, p)


@pytest.mark.parametrize(
    'function',
    [functools.partial(decay, k=2.0), functools.partial(Decay().method)],
    ids=['partial', 'partial method'],
)
@pytest.mark.parametrize('kind', ['dynamics', 'output'])
def test_whatever_can_be_called_becomes_a_plain_function(kind: str, function: Any) -> None:
    arguments = 0.0, (3.0,), (1.0,), (2.0,)
    made = getattr(plant(**{kind: function}), kind)
    assert isinstance(made, FunctionType)
    assert made(*arguments) == function(*arguments)


@pytest.mark.parametrize('function', [np.sin, 3.0, None])
def test_what_is_no_function_is_refused(function: Any) -> None:
    with pytest.raises(ValueError, match=r"'plant': dynamics must be a function of \(t, x, u, p\)"):
        plant(dynamics=function)


def test_a_function_that_its_author_compiled_is_taken_as_written() -> None:
    numba = pytest.importorskip('numba')
    assert plant(dynamics=numba.njit(decay)).dynamics is decay


def test_the_middle_of_the_bounds_may_be_singular() -> None:
    model = plant(
        states=[Variable('x', lower=-1.0, upper=1.0)],
        dynamics=lambda t, x, u, p: (1.0 / x[0],),
        output=lambda t, x, u, p: (np.log(x[0]),),
    )
    assert inside(model.states[0]) == 0.0


def test_an_output_may_have_the_name_of_the_state_it_measures() -> None:
    assert plant(outputs=[Variable('x')]).outputs[0].name == 'x'


@pytest.mark.parametrize(
    ('variable', 'value'),
    [
        (Variable('v', lower=0.0, upper=1.0, nominal=0.9), 0.9),
        (Variable('v', lower=2.0, upper=3.0), 2.5),
        (Variable('v', lower=2.0), 3.0),
        (Variable('v', upper=2.0), 1.0),
        (Variable('v'), 1.0),
    ],
)
def test_a_value_inside_the_bounds(variable: Variable, value: float) -> None:
    assert inside(variable) == value


@pytest.mark.parametrize(
    ('settings', 'message'),
    [
        ({'scale': 'ln'}, "k: scale 'ln' is none of linear, log"),
        (
            {'lower': 0.0, 'upper': 1.0, 'scale': 'log'},
            'k: bounds 0.0 and 1.0 must be positive and finite on a log scale',
        ),
        ({'scale': 'log'}, 'k: bounds -inf and inf must be positive and finite on a log scale'),
    ],
)
def test_a_scale_that_does_not_fit(settings: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=re.escape(message)):
        Variable('k', 'N/m', **settings)


@pytest.mark.parametrize('group', ['states', 'inputs', 'outputs'])
def test_only_parameters_may_have_a_log_scale(group: str) -> None:
    first, *others = getattr(THREE_TANK, group)
    changed = replace(first, lower=1.0, upper=2.0, nominal=None, scale='log')
    said = f"{first.name} has scale 'log', which only parameters may have"
    with pytest.raises(ValueError, match=re.escape(said)):
        replace(THREE_TANK, **{group: (changed, *others)})


@pytest.mark.parametrize('number', [int, np.int64, np.float32, float])
def test_numbers_of_a_variable_are_floats(number: Any) -> None:
    v = Variable('v', lower=number(1), upper=number(4), nominal=number(2), walk=number(3))
    assert [type(each) for each in (v.lower, v.upper, v.nominal, v.walk)] == [float] * 4
    assert v == Variable('v', lower=1.0, upper=4.0, nominal=2.0, walk=3.0)
    assert type(plant(max_step=number(1)).max_step) is float


@pytest.mark.parametrize('wrong', ['1', True, None, 1j, 10**400, [1.0]])
def test_what_is_no_number_is_refused_by_name(wrong: Any) -> None:
    with pytest.raises(ValueError, match=r'^v: lower must be a number, not '):
        Variable('v', lower=wrong)
    with pytest.raises(ValueError, match=r"^model 'plant': max_step must be a number, not "):
        plant(max_step=wrong)


def test_on_a_log_scale_there_are_walks_of_the_logarithm() -> None:
    found = Variable('k', 'N/m', lower=0.5, upper=1.0, scale='log', walk=0.1)
    assert (found.scale, found.walk) == ('log', 0.1)


def test_a_state_has_no_infinite_walk() -> None:
    said = "model 'plant': give state x a finite walk, not inf, which only parameters may have"
    with pytest.raises(ValueError, match=re.escape(said)):
        plant(states=[Variable('x', walk=math.inf)])


@pytest.mark.parametrize('given', [(3, 1), [3.0, 1.0], np.array([3.0, 1.0])])
def test_a_prior_is_two_floats(given: Any) -> None:
    found = Variable('k', prior=given)
    assert found.prior == (3.0, 1.0) and [type(each) for each in found.prior] == [float, float]
    assert hash(found) == hash(Variable('k', prior=(3.0, 1.0)))


@pytest.mark.parametrize(
    ('prior', 'message'),
    [
        (3.0, 'k: prior must be (mean, standard deviation), not 3.0'),
        ((3.0,), 'k: prior must be (mean, standard deviation), not (3.0,)'),
        ('ab', "k: prior must be (mean, standard deviation), not 'ab'"),
        ((3.0, '1'), "k: prior must be a number, not '1'"),
        ((math.nan, 1.0), 'k: prior mean nan is not finite'),
        ((3.0, 0.0), 'k: prior standard deviation 0.0 is not positive and finite'),
        ((3.0, -1.0), 'k: prior standard deviation -1.0 is not positive and finite'),
        ((3.0, math.inf), 'k: prior standard deviation inf is not positive and finite'),
        ((3.0, math.nan), 'k: prior standard deviation nan is not positive and finite'),
    ],
)
def test_what_is_no_prior_is_refused(prior: Any, message: str) -> None:
    with pytest.raises(ValueError, match=f'^{re.escape(message)}$'):
        Variable('k', prior=prior)


def test_on_a_log_scale_a_priors_mean_is_positive() -> None:
    with pytest.raises(ValueError, match=r'^k: prior mean -1.0 must be positive on a log scale$'):
        Variable('k', lower=0.5, upper=2.0, scale='log', prior=(-1.0, 0.5))


@pytest.mark.parametrize('physical', ['none', 'lower', 'upper', 'both'])
def test_bounds_that_a_plant_cannot_leave(physical: Any) -> None:
    assert Variable('k', lower=0.0, physical=physical).physical == physical
    assert Variable('k').physical == 'none'


@pytest.mark.parametrize('physical', ['', 'Lower', 'yes', None, True, ['lower']])
def test_what_is_no_such_bound_is_refused(physical: Any) -> None:
    with pytest.raises(ValueError, match=r'k: physical .* is none of none, lower, upper, both'):
        Variable('k', lower=0.0, physical=physical)


def test_noise_given_is_raised_by_that_of_rounding() -> None:
    outputs = [Variable('y', resolution=0.6), Variable('z')]
    model = plant(outputs=outputs, output=lambda t, x, u, p: (x[0], x[0]))
    assert outputs[0].rounding == pytest.approx(0.6 / math.sqrt(12.0)) and outputs[1].rounding == 0
    found = checked_noise(model, {'y': 0.1, 'z': 0.2})
    assert found == {'y': math.hypot(0.1, outputs[0].rounding), 'z': 0.2}
    assert checked_noise(model, {}) == {} == checked_noise(model, None)


def test_another_time_than_stamp_and_window_is_refused() -> None:
    assert plant().time == 'stamp'
    with pytest.raises(ValueError, match="time 'epoch' is none of stamp, window"):
        plant(time='epoch')
