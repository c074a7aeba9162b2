"""Kinks of plants' functions are found, with the line of their author."""

import math
from typing import Any

import numpy as np
import pytest

from obs_ros import Model, Variable
from obs_ros.core.kinks import kinks_of
from obs_ros.core.recorder import Untraceable
from obs_ros.models.three_tank import THREE_TANK

FILE = 'test_kinks.py'


def plant(dynamics: Any, **fields: Any) -> Model:
    return Model(
        name='plant',
        states=(Variable('s', lower=-3, upper=3), Variable('v', lower=-3, upper=3)),
        inputs=(Variable('f', **fields),),
        outputs=(Variable('s'),),
        parameters=(Variable('k', lower=0.1, upper=2),),
        dynamics=dynamics,
        output=lambda t, x, u, p: (x[0],),
    )


def branching(t: Any, x: Any, u: Any, p: Any) -> Any:
    force = -p[0] * x[0]
    if x[1] > 0.5 and x[0] < p[0]:
        force = force - 1.0
    for entry in x:
        force = force - max(0, entry) ** 1.5
    return [x[1], force + np.clip(u[0], -1, 1) - min(p[0] * x[1], 2)]


def stepping(t: Any, x: Any, u: Any, p: Any) -> Any:
    return x[1], math.floor(2 * t) - np.interp(x[0], [0, 1], [0, p[0]])


def test_a_function_as_its_author_wrote_it_is_named_by_line_and_variables() -> None:
    found = {(kink.place.split(': `', 1)[1], kink.where)
             for kink in kinks_of(plant(branching)).kinks}  # fmt: skip
    condition = 'if x[1] > 0.5 and x[0] < p[0]:`'
    assert found == {
        (condition, 'v = 0.5'),
        (condition, 's = k'),
        ('force = force - max(0, entry) ** 1.5`', 's = 0'),
        ('force = force - max(0, entry) ** 1.5`', 'v = 0'),
        ('return [x[1], force + np.clip(u[0], -1, 1) - min(p[0] * x[1], 2)]`', 'k * v = 2'),
    }
    assert all(kink.file.endswith(FILE) for kink in kinks_of(plant(branching)).kinks)


def test_helpers_of_built_in_models_are_named_once_for_each_call() -> None:
    kinks = kinks_of(THREE_TANK).kinks
    assert [kink.where for kink in kinks] == ['h1 - h3 = 0', 'h3 - h2 = 0', 'h2 = 0']
    assert len({kink.line for kink in kinks}) == 1
    assert 'np.copysign(np.sqrt(' in kinks[0].place


def test_kinks_are_met_where_a_solution_crosses_them() -> None:
    kinks, t = kinks_of(THREE_TANK), np.arange(11.0)
    x = np.column_stack([np.linspace(50, 30, 11), np.full(11, 20.0), np.full(11, 40.0)])
    u, p = np.full((11, 2), 30.0), np.array([0.5, 0.5, 0.5])
    assert kinks.met(t, x, u, p).tolist() == [True, False, False]
    x[5:] = np.nan
    assert kinks.met(t, x, u, p).tolist() == [False, False, False]


def test_steps_and_tables_are_kinks_too() -> None:
    kinks = kinks_of(plant(stepping))
    where = [kink.where for kink in kinks.kinks]
    assert where == ['floor(2 * t) jumps', 's = 0', 's = 1']
    t = np.linspace(0.1, 0.9, 9)
    x = np.column_stack([np.linspace(0.2, 1.2, 9), np.zeros(9)])
    assert kinks.met(t, x, np.zeros((9, 1)), np.ones(1)).tolist() == [True, False, True]


def test_a_smooth_function_has_none_whatever_its_inputs_do() -> None:
    kinks = kinks_of(
        plant(lambda t, x, u, p: (x[1], np.sin(x[0]) + np.abs(u[0]) - p[0] * x[1] ** 3))
    )
    assert kinks.kinks == ()
    assert kinks.met(np.arange(2.0), np.zeros((2, 2)), np.zeros((2, 1)), np.ones(1)).shape == (0,)


def test_a_delay_that_is_estimated_is_none_of_the_functions_parameters() -> None:
    kinks = kinks_of(plant(lambda t, x, u, p: (x[1], np.abs(x[0]) * p[-1]), delay=(0.0, 1.0)))
    assert [kink.where for kink in kinks.kinks] == ['s = 0']


def test_a_function_that_cannot_be_recorded_says_why() -> None:
    def foreign(t: Any, x: Any, u: Any, p: Any) -> Any:
        return x[1], float(str(float(abs(x[0])))) - p[0]

    with pytest.raises(Untraceable, match=FILE):
        kinks_of(plant(foreign))
