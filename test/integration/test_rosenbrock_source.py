"""Tests of obs_ros.integration.rosenbrock_source: what is made for one model."""

from dataclasses import replace

from plants import BLOW_UP, OSCILLATOR

from obs_ros.integration.rosenbrock_source import linear_model, made_for, method_texts, stages

IMPLICIT = replace(OSCILLATOR, integrator='rosenbrock')


def test_functions_are_made_for_linearly_implicit_steps_only() -> None:
    assert made_for(OSCILLATOR) == {}
    assert set(made_for(IMPLICIT)) == {'linearised', 'factored', 'solved'}


def test_stages_hold_only_derivatives_that_are_not_zero() -> None:
    linear = linear_model(IMPLICIT)
    assert linear.places == ((0, 1), (1, 0), (1, 1)) and linear.moving == (1,)
    text = stages(linear, 1)
    assert '    return (found[0], found[1] + a * found[5], )\n' in text
    assert 'def slopes(u0, u2, inverse):\n    return ((u2[0] - u0[0]) * inverse, )\n' in text
    alone = stages(linear_model(BLOW_UP), 0)
    assert 'def slopes(u0, u2, inverse):\n    return ()\n' in alone
    assert '    return (found[0], )\n' in alone


def test_modules_end_with_the_step_of_their_method() -> None:
    assert method_texts(OSCILLATOR) == ['step = step_rk4\n']
    assert method_texts(IMPLICIT)[-1] == 'step = step_rosenbrock\n'
