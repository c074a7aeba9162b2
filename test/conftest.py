"""Fixtures of every test."""

import getpass
import os
import signal
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, settings

from obs_ros.core.deadline import Deadline

# Where these tests run in the background of a script, Ctrl-C is ignored, and what they start would
# inherit that: Bash could not even trap it.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

# Properties are the same at every run, on every machine, however busy.
settings.register_profile(
    'gate',
    deadline=None,
    derandomize=True,
    database=None,
    suppress_health_check=[HealthCheck.too_slow],
)
settings.load_profile('gate')

# Deadlines count the time that their thread computes, not that in which others have the processor.
Deadline._now = staticmethod(time.thread_time)  # type: ignore[method-assign]

# Kernels compile once, for all workers, and stay for the next run, apart from the user's own.
os.environ['OBS_ROS_CACHE'] = str(
    Path(tempfile.gettempdir()) / f'obs_ros_test_kernels_{getpass.getuser()}'
)
os.environ.pop('OBS_ROS_BACKEND', None)


@pytest.fixture(params=['numba', 'numpy'])
def backend(request: pytest.FixtureRequest) -> str:
    """Both ways to roll out."""
    if request.param == 'numba':
        pytest.importorskip('numba')
    return str(request.param)


@pytest.fixture
def ros() -> Iterator[Any]:
    """Nodes in a ROS context of their own, closed at the end; see `ros.Ros`."""
    pytest.importorskip('rclpy')
    from ros import Ros

    ros = Ros()
    try:
        yield ros
    finally:
        ros.close()
