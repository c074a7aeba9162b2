"""Time from the start of a new process to its first estimate, with a cold and a warm kernel cache.

Cold: an empty cache folder, as after installation or with a new model; Python's own byte code is
there. Warm: the kernels that an earlier process left.
"""

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

from benchmarks.common import Progress, machine, mark, options, publish
from benchmarks.common import table as markdown
from benchmarks.tanks import random_window

LIMITS = {'cold': 15.0, 'warm': 3.0}  # s
PHASES = ('import', 'compile', 'solve')

Start = Mapping[str, float]  # seconds by name: wall, cpu and the phases


def main(arguments: list[str] | None = None) -> Mapping[str, Sequence[Start]]:
    """Measure, print, and write the report."""
    parser = options(__doc__)
    parser.add_argument('--cold', type=int, default=3, help='starts with an empty cache')
    parser.add_argument('--warm', type=int, default=5, help='starts with a filled cache')
    chosen = parser.parse_args(arguments)
    progress = Progress('start', chosen.cold + chosen.warm)
    starts: dict[str, list[Start]] = {'cold': [], 'warm': []}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        record = random_window(1, 1000, 20.0).record
        np.savez(folder / 'window.npz', t=record.t, u=record.u, y=record.y)
        for number in range(chosen.cold):
            starts['cold'].append(started(folder, folder / f'cache{number}'))
            progress.step()
        for _ in range(chosen.warm):
            starts['warm'].append(started(folder, folder / 'cache0'))
            progress.step()
    publish(
        chosen.results, 'start_up', 'First estimate of a new process', report(starts), machine()
    )
    return starts


def started(folder: Path, cache: Path) -> Start:
    """Solve the window in a new process and return its seconds."""
    root = Path(__file__).parents[2]
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    begin = time.monotonic()
    with subprocess.Popen(
        [sys.executable, '-m', 'benchmarks.start_up.first_solve', str(folder / 'window.npz')],
        cwd=root,
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


def report(starts: Mapping[str, Sequence[Start]]) -> list[str]:
    """Return the parts of the report."""
    rows = []
    for cache, measured in starts.items():
        medians = {
            name: float(np.median([start[name] for start in measured])) for name in measured[0]
        }
        limit = LIMITS[cache]
        rows.append(
            (
                cache,
                len(measured),
                f'{medians["wall"]:.2f}',
                f'{min(start["wall"] for start in measured):.2f}',
                *(f'{medians[name]:.2f}' for name in ('cpu', *PHASES)),
                f'{limit:g}',
                mark(medians['wall'] <= limit),
            )
        )
    head = (
        'kernel cache', 'starts', 'wall (s)', 'fastest (s)', 'process time (s)',
        *(f'{phase} (s)' for phase in PHASES), 'limit (s)', 'within',
    )  # fmt: skip
    return [
        'Medians. Wall: from the start of the process to the first estimate of a three-tank window '
        'of 1000 samples and 6 unknowns, on a machine that others use too; process time: of the '
        'whole process, to its end. The phases are wall times.',
        markdown(head, rows),
    ]
