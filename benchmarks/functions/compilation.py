"""Process time of the first compilation of a model's kernels, in processes of their own."""

import os
import resource
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import NamedTuple

import numpy as np

from benchmarks.functions.models import FUNCTIONS, spring
from benchmarks.runner import ROOT
from obs_ros import Model
from obs_ros.integration.backends import kernels_for
from obs_ros.models.three_tank import THREE_TANK

MODELS = ('three tanks', 'where', 'sin', 'power')  # the last ones are springs


class Compilation(NamedTuple):
    """Medians of the process time in s, imports included; NaN without another tree."""

    model: str
    ours: float
    theirs: float


def compilations(starts: int, against: Path | None) -> list[Compilation]:
    """Measure each model in so many new processes, by turns with those of another tree."""
    trees = [ROOT, *([against.resolve()] if against else [])]
    found = []
    for name in MODELS:
        times = [[seconds(name, tree) for tree in trees] for _ in range(starts)]
        medians = [*map(float, np.median(times, axis=0)), np.nan]
        found.append(Compilation(name, *medians[:2]))
    return found


def seconds(name: str, tree: Path) -> float:
    """Return the process time of a new process that compiles this model with this tree."""
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, 'obs_ros').symlink_to(tree / 'obs_ros')
        paths = f'{folder}{os.pathsep}{ROOT}'
        environment = {**os.environ, 'PYTHONPATH': paths, 'OBS_ROS_CACHE': f'{folder}/cache'}
        before = spent()
        command = [sys.executable, '-P', '-m', __name__, name]
        subprocess.run(command, env=environment, cwd=ROOT, check=True)
        return spent() - before


def spent() -> float:
    """Return the process time in s of the processes that have ended."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def model_of(name: str) -> Model:
    """Return a model by its name here."""
    return spring(FUNCTIONS[name].python) if name in FUNCTIONS else THREE_TANK


if __name__ == '__main__':
    kernels_for(model_of(sys.argv[1]), 'numba')
