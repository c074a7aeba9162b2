"""Recordings of a ball on a beam for studies, their results, and work for other processes."""

import os
import signal
from pathlib import Path

import numpy as np
from ball_and_beam import made_up, write_table

GIVEN = {'model': 'ball_and_beam:BALL', 'window.duration': 5.0, 'window.period': 2.5}
ROWS = 110  # two windows and a bit, and the forecast of the first


def recordings(folder: Path, count: int) -> list[Path]:
    """Write tables that differ by their noise; return their paths."""
    return [
        write_table(folder / f'rig{seed}.csv', *made_up(rows=ROWS, seed=seed))
        for seed in range(1, count + 1)
    ]


def parameter_file(folder: Path) -> Path:
    """Write the parameters."""
    lines = [f'    {name}: {value}' for name, value in GIVEN.items()]
    path = folder / 'rig.yaml'
    path.write_text('\n'.join(['/**/estimator:', '  ros__parameters:', *lines]) + '\n')
    return path


def bits(columns) -> dict[str, object]:
    """Return columns as what can be compared bit by bit."""
    return {n: c.tobytes() if isinstance(c, np.ndarray) else list(c) for n, c in columns.items()}


def pid_of(value):
    """Return the value, the process that has it, and its threads of linear algebra."""
    return value, os.getpid(), os.environ.get('OPENBLAS_NUM_THREADS')


def deadly(value):
    """Kill the process that has 1."""
    if value == 1:
        os.kill(os.getpid(), signal.SIGKILL)
    return value
