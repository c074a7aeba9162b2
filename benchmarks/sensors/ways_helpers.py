"""Helpers that a model's functions call from another module."""

from typing import Any

import numpy as np


def limited(value: Any, most: float) -> Any:
    """Return a value within limits of either sign."""
    return np.minimum(np.maximum(value, -most), most)


def pull(x: Any, p: Any, reach: float) -> Any:
    """Return the force of spring and friction."""
    return p[0] * np.sin(limited(x[0], reach)) + p[1] * x[1]
