"""New processes that solve one window as the first thing they do, timed as wholes."""

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

PHASES = ('import', 'solve')
IMPORTS = 'import numpy, scipy, numba'  # which a first estimate needs whatever this package does

Start = Mapping[str, float]  # seconds by name: wall, cpu and the phases


def starts_of(rounds: int) -> Mapping[str, Sequence[Start]]:
    """Return starts by turns: of the imports alone, with a filled cache, and with an empty one."""
    starts: dict[str, list[Start]] = {'imports': [], 'warm': [], 'cold': []}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        record = random_window(1, 1000, 20.0).record
        np.savez(folder / 'window.npz', t=record.t, u=record.u, y=record.y)
        solve = ['-m', 'benchmarks.start_up.first_solve', str(folder / 'window.npz')]
        started(solve, folder / 'filled')
        for number in progress(range(rounds), 'round', rounds):
            starts['imports'].append(started(['-c', IMPORTS], folder / 'filled'))
            starts['warm'].append(started(solve, folder / 'filled'))
            starts['cold'].append(started(solve, folder / f'empty{number}'))
    return starts


def started(command: Sequence[str], cache: Path) -> Start:
    """Run a new process to its end and return its seconds."""
    environment = {**os.environ, 'OBS_ROS_CACHE': str(cache)}
    environment.pop('PYTHONDONTWRITEBYTECODE', None)  # byte code is there, as after installation
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    begin = time.monotonic()
    done = subprocess.run(
        [sys.executable, *command], cwd=ROOT, env=environment,
        stdout=subprocess.PIPE, text=True, check=True,
    )  # fmt: skip
    wall = time.monotonic() - begin
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    phases = json.loads(done.stdout or '{}')
    if phases and phases['outcome'] != 'converged':
        raise RuntimeError(f'the first estimate of the new process is {phases["outcome"]}')
    return {'wall': wall, 'cpu': cpu, **{phase: phases.get(phase, np.nan) for phase in PHASES}}
