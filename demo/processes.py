"""Start the installed executables as `ros2 run` does, and end them as Ctrl-C does."""

import os
import signal
import subprocess
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from ament_index_python.packages import get_package_prefix

PATIENCE = 60.0  # s that a process gets to end after SIGINT, on a machine however busy


@contextmanager
def executable(name: str, parameters: Mapping[str, object]) -> Iterator[subprocess.Popen[bytes]]:
    """Run an executable of this package with ROS parameters, until the block ends.

    Raises RuntimeError when it does not end with exit code 0 on SIGINT.
    """
    path = Path(get_package_prefix('obs_ros')) / 'lib' / 'obs_ros' / name
    assignments = [f'{key}:={value}' for key, value in parameters.items()]
    flags = [flag for assignment in assignments for flag in ('-p', assignment)]
    # In a session of its own: Ctrl-C in the terminal is for the demo, which passes it on.
    process = subprocess.Popen(
        [path, '--ros-args', '--log-level', 'warn', *flags], env=os.environ, start_new_session=True
    )
    try:
        yield process
    finally:
        process.send_signal(signal.SIGINT)
        try:
            code = process.wait(PATIENCE)
        except subprocess.TimeoutExpired:
            process.kill()
            raise RuntimeError(f'{name} did not end within {PATIENCE} s of SIGINT') from None
    if code != 0:
        raise RuntimeError(f'{name} ended with exit code {code}')
