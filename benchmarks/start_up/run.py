"""New processes that solve one window as the first thing they do, timed from their start."""

import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from benchmarks.runner import ROOT, progress
from benchmarks.tanks import random_window

PHASES = ('import', 'compile', 'solve')

Start = Mapping[str, float]  # seconds by name: wall, cpu and the phases


def starts_of(cold: int, warm: int) -> Mapping[str, Sequence[Start]]:
    """Return starts with an empty cache, and with the one that the first of them filled."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        record = random_window(1, 1000, 20.0).record
        np.savez(folder / 'window.npz', t=record.t, u=record.u, y=record.y)
        caches = [folder / f'cache{number}' for number in range(cold)] + [folder / 'cache0'] * warm
        starts = [started(folder, cache) for cache in progress(caches, 'start', cold + warm)]
    return {'cold': starts[:cold], 'warm': starts[cold:]}


def started(folder: Path, cache: Path) -> Start:
    """Solve the window in a new process and return its seconds."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    begin = time.monotonic()
    with subprocess.Popen(
        [sys.executable, '-m', 'benchmarks.start_up.first_solve', str(folder / 'window.npz')],
        cwd=ROOT,
        env={**os.environ, 'OBS_ROS_CACHE': str(cache)},
        stdout=subprocess.PIPE,
        text=True,
    ) as child:
        assert child.stdout is not None
        line = child.stdout.readline()
        wall = time.monotonic() - begin
    if child.returncode != 0:
        raise RuntimeError(f'the new process ended with exit code {child.returncode}')
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    phases = json.loads(line)
    if phases['outcome'] != 'converged':
        raise RuntimeError(f'the first estimate of the new process is {phases["outcome"]}')
    return {'wall': wall, 'cpu': cpu, **{phase: phases[phase] for phase in PHASES}}
