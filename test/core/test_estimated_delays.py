"""Tests of obs_ros.core.estimated_delays, and of models that have such delays."""

from dataclasses import replace

import pytest
from plants import LAG

from obs_ros import Model, Variable
from obs_ros.core.estimated_delays import is_delay, of_first, plain, refuse, signal_of
from obs_ros.core.model import names


def late(model: Model, bounds: tuple[float, float] = (-0.1, 0.5)) -> Model:
    return replace(model, outputs=[replace(v, delay=bounds) for v in model.outputs])


def test_a_delay_is_one_more_parameter_in_seconds_with_its_bounds() -> None:
    model = late(LAG)
    assert names(model.parameters) == ('k', 'tau', 'y.delay')
    delay = model.variable('y.delay')
    assert (delay.unit, delay.lower, delay.upper, delay.physical) == ('s', -0.1, 0.5, 'none')
    assert late(LAG, (0.0, 0.5)).variable('y.delay').physical == 'lower'
    assert is_delay('y.delay') and not is_delay('delay') and signal_of('y.delay') == 'y'


def test_the_functions_get_their_own_parameters_alone() -> None:
    model = late(LAG)
    assert model.dynamics(0.0, (1.0,), (3.0,), (2.0, 5.0, 0.3)) == (1.0,)
    assert plain(model.dynamics) is LAG.dynamics and plain(LAG.dynamics) is LAG.dynamics


def test_another_copy_has_the_same_functions_and_what_was_known_of_the_delay() -> None:
    model = late(LAG)
    known = replace(
        model, parameters=[replace(v, prior=(0.2, 0.1)) if v.unit == 's' else v
                           for v in model.parameters[2:]] + list(model.parameters[:2]),
    )  # fmt: skip
    assert names(known.parameters) == ('k', 'tau', 'y.delay')
    assert known.dynamics is model.dynamics
    assert known.variable('y.delay').prior == (0.2, 0.1)
    assert late(known, (0.0, 0.4)).variable('y.delay').prior == (0.2, 0.1)


def test_a_delay_that_becomes_known_is_no_parameter_any_more() -> None:
    model = replace(late(LAG), outputs=LAG.outputs)
    assert model == LAG and model.dynamics is LAG.dynamics


def test_one_function_of_fewer_parameters_is_one_object() -> None:
    def f(t, x, u, p):
        return (sum(p),)

    assert of_first(f, 2) is of_first(f, 2)
    assert of_first(f, 2)(0.0, (), (), (1.0, 2.0, 4.0)) == (3.0,)
    assert of_first(f, 0)(0.0, (), (), (1.0,)) == (0,)


def test_input_and_output_of_one_name_cannot_both_have_one() -> None:
    both = {
        'inputs': [Variable('y', delay=(0.0, 1.0))],
        'outputs': [Variable('y', delay=(0.0, 1.0))],
    }
    with pytest.raises(ValueError, match=r"more than one variable 'y\.delay'"):
        replace(LAG, **both)


def test_observers_that_find_none_say_what_to_do() -> None:
    refuse(('k', 'tau'), 'EKF')
    with pytest.raises(ValueError, match='give the delay of y as one number, or take the observer'):
        refuse(('k', 'y.delay'), 'EKF')
