"""Roll, pitch and yaw of orientations: what paths to numbers may ask of a quaternion.

They are those of REP 103, in rad: a turn by yaw about z, then by pitch about the new y, then by
roll about the new x. Yaw and roll lie in [-pi, pi], pitch in [-pi/2, pi/2].
"""

import math
from dataclasses import dataclass
from typing import Any

ANGLES = ('roll', 'pitch', 'yaw')
TYPES = ('geometry_msgs/Quaternion', 'geometry_msgs/msg/Quaternion')


@dataclass(frozen=True)
class QuaternionSettings:
    """Limit of what is a rotation.

    - `norm`: how far from 1 the norm may be; rounding to three digits stays below .002, and a
      message that nobody filled in has 0.
    """

    norm: float = 0.01


SETTINGS = QuaternionSettings()


def is_quaternion(message: Any) -> bool:
    """Whether a message, of rclpy or read from a bag, is a geometry_msgs/Quaternion."""
    return type(message).__name__.rpartition('__')[2] == 'Quaternion'


def angle_of(message: Any, name: str, settings: QuaternionSettings = SETTINGS) -> float:
    """Return one of the ANGLES of a quaternion, in rad; raises ValueError where it is none."""
    return dict(zip(ANGLES, angles(message, settings), strict=True))[name]


def angles(message: Any, settings: QuaternionSettings = SETTINGS) -> tuple[float, float, float]:
    """Return roll, pitch and yaw in rad; raises ValueError for a norm far from 1."""
    x, y, z, w = (float(getattr(message, field)) for field in 'xyzw')
    norm = math.hypot(x, y, z, w)
    if not abs(norm - 1.0) <= settings.norm:
        raise ValueError(f'the quaternion ({x:g}, {y:g}, {z:g}, {w:g}) has norm {norm:g}, not 1')
    x, y, z, w = (part / norm for part in (x, y, z, w))
    roll = math.atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
    pitch = math.asin(min(max(2.0 * (w * y - z * x), -1.0), 1.0))
    yaw = math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    return roll, pitch, yaw


def turn(message: Any, name: str, value: float) -> None:
    """Give a quaternion one of the ANGLES, in rad, its others as they were; 0 where it was none."""
    try:
        found = dict(zip(ANGLES, angles(message), strict=True))
    except ValueError:
        found = dict.fromkeys(ANGLES, 0.0)
    halves = ({**found, name: value}[angle] / 2.0 for angle in ANGLES)
    (sr, cr), (sp, cp), (sy, cy) = ((math.sin(half), math.cos(half)) for half in halves)
    message.x = sr * cp * cy - cr * sp * sy
    message.y = cr * sp * cy + sr * cp * sy
    message.z = cr * cp * sy - sr * sp * cy
    message.w = cr * cp * cy + sr * sp * sy
