"""Helpers of a plant that stand in a module of their own."""

import math
from typing import Any

import numpy as np

GRAVITY = 3.0  # 1/s2


def pull(angle: Any) -> Any:
    """Return the pull of gravity on a pendulum."""
    return GRAVITY * math.sin(angle)


def sliding(speed: Any) -> Any:
    """Return a force against the motion that begins beyond a speed of .1."""
    return np.maximum(np.abs(speed) - 0.1, 0.0) * np.tanh(speed)
