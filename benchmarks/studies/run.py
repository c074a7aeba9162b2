"""A study of many recordings in several ways, each as processes of its own, timed by the wall."""

import csv
import hashlib
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

from benchmarks.play import played
from benchmarks.runner import ROOT, progress
from obs_ros.core.model import names
from obs_ros.models import load_model

PLANT = 'three_tank'
SNR_DB = 20.0
DURATIONS = (100, 150, 200, 250, 300)  # s of the windows: the variants
PERIOD = 100  # s from window to window
BARE, STUDY, JOBS, SCHEDULER = 'bare', 'study', '--jobs', '--scheduler'
ONE, TWO = f'one {BARE} process', f'two {BARE} processes'
ALONE, LOCAL, REMOTE = f'{STUDY}, one process', f'{STUDY}, {JOBS} 2', f'{STUDY}, {SCHEDULER}'
WAYS = (ONE, TWO, ALONE, LOCAL, REMOTE)
LOOK = 0.02  # s between two looks at what a process has done
PATIENCE = 60.0  # s for a scheduler to start, or to end


class Course(NamedTuple):
    """A study whose worker was killed, that was stopped, and went on.

    So many results were there when it was stopped; `rewritten` were written again afterwards.
    """

    stopped_at: int
    rewritten: int
    results: int
    digest: str


class Measured(NamedTuple):
    """Wall times (s) by way, hashes of the tables of studies, and the one that was disturbed."""

    seconds: Mapping[str, Sequence[float]]
    digests: Sequence[str]
    course: Course
    runs: int


class Plan(NamedTuple):
    """Recordings and parameters in a folder, and the words of the command."""

    folder: Path
    recordings: Sequence[Path]

    @property
    def words(self) -> list[str]:
        """The command's arguments, but for the way."""
        vary = f'window.duration={",".join(map(str, DURATIONS))}'
        parameters = str(self.folder / 'plant.yaml')
        return [*map(str, self.recordings), '--params', parameters, '--vary', vary]

    @property
    def runs(self) -> int:
        """Number of runs."""
        return len(self.recordings) * len(DURATIONS)


def made(folder: Path, recordings: int, samples: int, seed: int) -> Plan:
    """Let the simulator write so many tables, each with noise of its own."""
    (folder / 'plant.yaml').write_text(
        f'/**:\n  ros__parameters:\n    model: {PLANT}\n    window.period: {PERIOD}.0\n'
    )
    model, paths = load_model(PLANT), []
    for k in range(recordings):
        paths.append(folder / f'tanks{k:03}.csv')
        with paths[-1].open('w') as file:
            rows = csv.writer(file)
            rows.writerow(('t', *names(model.inputs), *names(model.outputs)))
            for instant in played(PLANT, samples, seed=seed + k, snr_db=SNR_DB):
                rows.writerow((instant.t, *instant.u, *instant.y))
    return Plan(folder, paths)


def measured(plan: Plan, rounds: int) -> Measured:
    """Carry the study out in every way, way after way, so many times."""
    seconds: dict[str, list[float]] = {way: [] for way in WAYS}
    digests = []
    first = plan._replace(recordings=plan.recordings[:1])
    _wait(_study(first, plan.folder / 'warm'))  # compiles
    with _cluster(plan.folder) as address:
        todo = [(turn, way) for turn in range(rounds) for way in WAYS]
        for turn, way in progress(todo, 'ways', len(todo)):
            folder = plan.folder / f'{turn} {way}'
            begin = time.monotonic()
            for process in _started(plan, way, folder, address):
                _wait(process)
            seconds[way].append(time.monotonic() - begin)
            if way not in (ONE, TWO):
                digests.append(_digest(folder))
    return Measured(seconds, digests, disturbed(plan), plan.runs)


def disturbed(plan: Plan) -> Course:
    """Kill a worker at a third of the study, stop it at two thirds, and let it go on."""
    import psutil  # which Dask brings

    folder = plan.folder / 'disturbed'
    process = _study(plan, folder, JOBS, '2')
    _until(process, lambda: len(_results(folder)) >= plan.runs // 3)
    workers = [
        child for child in psutil.Process(process.pid).children()
        if any('spawn_main' in word for word in child.cmdline())
    ]  # fmt: skip
    workers[0].kill()
    _until(process, lambda: len(_results(folder)) >= 2 * plan.runs // 3)
    os.killpg(process.pid, signal.SIGINT)
    process.wait()
    kept = _results(folder)
    _wait(_study(plan, folder, JOBS, '2'))
    after = _results(folder)
    rewritten = sum(after.get(name) != place for name, place in kept.items())
    return Course(len(kept), rewritten, len(after), _digest(folder))


def _started(plan: Plan, way: str, folder: Path, address: str) -> list[subprocess.Popen[bytes]]:
    """Start the processes of a way."""
    if way in (ONE, TWO):
        shares = 1 if way == ONE else 2
        return [
            _python('benchmarks.studies.bare', json.dumps([share, shares]), *plan.words,
                    '--output', str(folder / str(share)))
            for share in range(shares)
        ]  # fmt: skip
    options = {ALONE: (), LOCAL: (JOBS, '2'), REMOTE: (SCHEDULER, address)}[way]
    return [_study(plan, folder, *options)]


def _study(plan: Plan, folder: Path, *options: str) -> subprocess.Popen[bytes]:
    return _python('obs_ros.replay', *plan.words, '--output', str(folder), *options)


def _python(*words: str) -> subprocess.Popen[bytes]:
    """Start a module as a group of its own, with one thread of linear algebra.

    All are of one session: the kernel shares processors among sessions first.
    """
    return subprocess.Popen(
        [sys.executable, '-m', *words], cwd=ROOT, stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL, process_group=0,
        env={**os.environ, 'OPENBLAS_NUM_THREADS': '1', 'PYTHONPATH': str(ROOT)},
    )  # fmt: skip


@contextmanager
def _cluster(folder: Path) -> Iterator[str]:
    """Start a scheduler and two workers, each a process, on the loopback; give the address."""
    file = folder / 'scheduler.json'
    own = ('--host', '127.0.0.1', '--no-dashboard', '--scheduler-file', str(file))
    started = [_python('dask', 'scheduler', '--port', '0', *own)]
    try:
        _until(started[0], file.exists, PATIENCE)
        started += [_python('dask', 'worker', '--nthreads', '1', *own) for _ in range(2)]
        yield json.loads(file.read_text())['address']
    finally:
        for process in reversed(started):
            process.terminate()
            try:
                process.wait(PATIENCE)
            except subprocess.TimeoutExpired:
                process.kill()


def _wait(process: subprocess.Popen[bytes]) -> None:
    """Wait for a process; raises RuntimeError where it fails."""
    if process.wait():
        raise RuntimeError(f'{process.args} ended with {process.returncode}')


def _until(process: subprocess.Popen[bytes], reached, seconds: float = float('inf')) -> None:
    end = time.monotonic() + seconds
    while not reached():
        if process.poll() is not None or time.monotonic() > end:
            raise RuntimeError(f'{process.args} ended with {process.returncode}')
        time.sleep(LOOK)


def _results(folder: Path) -> dict[str, int]:
    """Return the results by name: which file each is; one that is written again is another."""
    return {path.name: path.stat().st_ino for path in folder.glob('results/*.result')}


def _digest(folder: Path) -> str:
    return hashlib.sha256((folder / 'estimates.csv').read_bytes()).hexdigest()
