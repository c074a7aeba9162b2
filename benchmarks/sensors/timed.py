"""The process time of a window of the spring, by whatever source tree runs this."""

from collections.abc import Mapping
from typing import Any

from benchmarks.runner import timed
from benchmarks.sensors.spring_model import SPRING
from obs_ros import Record, solve_window

REPEATS = 5  # of a timed solve, of which the least counts


def least_seconds(record: Record, seed: int, options: Mapping[str, Any]) -> float:
    """Return the process time (s) of a window with these settings, the least of some."""
    return min(
        timed(lambda: solve_window(SPRING, record, seed=seed, **options))[1] for _ in range(REPEATS)
    )
