"""What check_model says of sensors and actuators, and what it refuses."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from obs_ros import Variable
from obs_ros.cli.model_sensors import check_sensors, declared, limited, shown
from obs_ros.models import load_model

TANKS = load_model('three_tank')


@pytest.mark.parametrize(
    ('fields', 'words'),
    [
        ({}, ''),
        ({'period': 6.25}, ', period 6.25 cm'),
        ({'delay': -0.05}, ', delay -0.05 s'),
        ({'delay': (0, 2), 'range': (0, math.inf)},
         ', delay estimated within 0 to 2 s, range 0 to inf cm'),
        ({'resolution': 0.5, 'unit': '1'}, ', resolution 0.5'),
    ],
)  # fmt: skip
def test_what_is_declared_is_told_with_its_unit(fields: dict[str, Any], words: str) -> None:
    assert declared(Variable('h', **{'unit': 'cm', **fields})) == words


@pytest.mark.parametrize(
    ('kind', 'fields', 'words'),
    [
        ('outputs', {'delay': 10.0}, r'^output h1: take a longer --window, .* 10 s are no less'),
        ('inputs', {'delay': (-40.0, 1.0)}, r'^input Q1: take a longer --window, .* 40 s are no'),
        ('inputs', {'range': (0.0, 20.0)}, r'^input Q1: change the range .* 30 lies outside 0 to'),
        ('outputs', {'range': (0.0, 2.0), 'resolution': 2.0}, r'^output h1: make .* finer than 2,'),
        ('outputs', {'period': 1.0, 'resolution': 2.0}, r'^output h1: make .* period is 1'),
    ],
)
def test_what_cannot_be_meant_is_refused(kind: Any, fields: dict[str, Any], words: str) -> None:
    first, *others = getattr(TANKS, kind)
    model = replace(TANKS, **{kind: [replace(first, **fields), *others]})
    with pytest.raises(ValueError, match=words):
        check_sensors(model, 10.0)


def test_what_can_be_meant_passes() -> None:
    check_sensors(TANKS, 10.0)
    inputs = [replace(v, delay=(0.0, 9.0), range=(0.0, 30.0)) for v in TANKS.inputs]
    outputs = [replace(v, delay=-9.0, range=(0.0, 9.0), resolution=1.0) for v in TANKS.outputs]
    check_sensors(replace(TANKS, inputs=inputs, outputs=outputs), 10.0)


def test_what_is_lost_at_limits_or_by_rounding_is_told() -> None:
    values = np.linspace(0.0, 1.0, 101)
    assert limited(Variable('u'), values) == shown(Variable('y'), values) == ''
    assert limited(Variable('u', range=(0.0, 1.0)), values) == ''
    assert limited(Variable('u', range=(0.1, math.inf)), values) == (
        '; its actuator limits 10% of the samples'
    )
    assert shown(Variable('y', range=(-1.0, 0.505)), values).endswith(' 50% of the samples')
    assert shown(Variable('y', resolution=0.5), values) == ''
    coarse = '; all that it moves by is less than its resolution'
    assert shown(Variable('y', resolution=2.0), values) == coarse
    assert shown(Variable('y', resolution=2.0), 0.0 * values) == ''
