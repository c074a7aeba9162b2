"""Tests of obs_ros.interface.quaternion."""

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from obs_ros.interface.quaternion import ANGLES, angle_of, angles, is_quaternion, turn

TURNS = st.floats(-math.pi, math.pi)
Read = type('geometry_msgs__msg__Quaternion', (SimpleNamespace,), {})


def message(x: float = 0.0, y: float = 0.0, z: float = 0.0, w: float = 1.0) -> Any:
    return Read(x=x, y=y, z=z, w=w)


@given(TURNS, st.floats(-1.5, 1.5), TURNS)
def test_angles_are_those_of_another_library(roll: float, pitch: float, yaw: float) -> None:
    x, y, z, w = Rotation.from_euler('ZYX', [yaw, pitch, roll]).as_quat()
    for sign in (1.0, -1.0):
        found = angles(message(sign * x, sign * y, sign * z, sign * w))
        off = np.array(found) - (roll, pitch, yaw)
        np.testing.assert_allclose(np.cos(off), 1.0, atol=1e-9)


@given(TURNS, st.floats(-1.5, 1.5), TURNS)
def test_a_quaternion_takes_its_angles_one_by_one(roll: float, pitch: float, yaw: float) -> None:
    orientation, values = message(), dict(zip(ANGLES, (roll, pitch, yaw), strict=True))
    for name in ('yaw', 'roll', 'pitch'):
        turn(orientation, name, values[name])
    for name, value in values.items():
        assert math.cos(angle_of(orientation, name) - value) == pytest.approx(1.0, abs=1e-9)


def test_straight_up_is_a_rotation_too() -> None:
    """Rounding must not lead out of the arc sine; yaw and roll are one there."""
    half = math.sqrt(0.5)
    assert angles(message(y=half, w=half))[1] == pytest.approx(math.pi / 2)


@pytest.mark.parametrize('scale', [0.991, 1.009])
def test_rounded_quaternions_are_normalised(scale: float) -> None:
    z, w = scale * math.sin(0.4), scale * math.cos(0.4)
    assert angle_of(message(z=z, w=w), 'yaw') == pytest.approx(0.8)


@pytest.mark.parametrize('parts', [(0.0,) * 4, (0.0, 0.0, 0.0, 0.98), (math.nan,) * 4, (1.0,) * 4])
def test_what_is_no_rotation_is_refused(parts: Any) -> None:
    with pytest.raises(ValueError, match=r'the quaternion \(.*\) has norm .*, not 1'):
        angles(message(*parts))
    broken = message(*parts)
    turn(broken, 'yaw', 0.5)
    assert angles(broken) == pytest.approx((0.0, 0.0, 0.5))


def test_quaternions_are_known_by_their_type() -> None:
    assert is_quaternion(message()) and not is_quaternion(SimpleNamespace(x=0, y=0, z=0, w=1))
