"""Tests of obs_ros.core.straight_line: which functions stay as they were written."""

from typing import Any

import numpy as np
import pytest

from obs_ros.core.registry import lookup
from obs_ros.core.straight_line import is_straight
from obs_ros.models import MODELS

SWITCH = True


def helper(x: Any) -> Any:
    return np.where(x > 0, np.sqrt(np.abs(x)), abs(x))


def looping(x: Any) -> Any:
    for _ in range(2):
        x = x * x
    return x


@pytest.mark.parametrize(
    'function',
    [
        lambda t, x, u, p: (helper(x[0]) * np.pi, x[1]),
        lambda t, x, u, p: (x[0] if SWITCH else x[1], np.clip(x[0], 0, 1)),
        lambda t, x, u, p: (abs(x[1]), p[0] ** 2),
    ],
)
def test_numbers_helpers_and_tuples_are_straight(function: Any) -> None:
    assert is_straight(function)


@pytest.mark.parametrize(
    'function',
    [
        lambda t, x, u, p: [x[0]],
        lambda t, x, u, p: np.array(x) @ x,
        lambda t, x, u, p: (looping(x[0]),),
        lambda t, x, u, p: (sum(x),),
        lambda t, x, u, p: (max(x),),
        lambda t, x, u, p: tuple(a for a in x),
        lambda t, x, u, p: (np.linalg.norm(x),),
        lambda t, x, u, p: (np.interp(x[0], (0, 1), (0, 1)),),
        lambda t, x, u, p: (x[0] ** p[0],),
        lambda t, x, u, p: (x[0] ** 0.5,),
        lambda t, x, u, p: (np.power(x[0], 2),),
    ],
)
def test_loops_lists_arrays_matrices_and_powers_are_not(function: Any) -> None:
    assert not is_straight(function)


@pytest.mark.parametrize('name', MODELS)
def test_the_models_of_the_package_stay_as_they_are(name: str) -> None:
    model: Any = lookup('model', name, MODELS)
    for function in (model.dynamics, model.output):
        assert is_straight(function)
        assert not function.__code__.co_filename.startswith('<')
