"""Tests of obs_ros.horizon.settings."""

import inspect
from dataclasses import FrozenInstanceError, fields

import pytest

from obs_ros import solve_window
from obs_ros.horizon.settings import EstimationSettings


def test_the_front_door_has_every_setting_with_the_same_default() -> None:
    front = inspect.signature(solve_window).parameters
    for field in fields(EstimationSettings):
        default = getattr(EstimationSettings(), field.name)
        assert (front[field.name].default or None) == (default or None), field.name
    others = set(front) - {field.name for field in fields(EstimationSettings)}
    assert others == {'model', 'record', 'seed', 'deadline', 'previous'}


def test_they_are_documented_and_do_not_change() -> None:
    settings = EstimationSettings(fitness='euclidean')
    for field in fields(settings):
        assert f'`{field.name}`' in str(EstimationSettings.__doc__)
    with pytest.raises(FrozenInstanceError):
        settings.fitness = 'least_squares'  # type: ignore[misc]
    with pytest.raises(TypeError, match='fitnes'):
        EstimationSettings(fitnes='euclidean')  # type: ignore[call-arg]
