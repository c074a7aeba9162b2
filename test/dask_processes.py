"""Schedulers and workers of Dask as real processes on the loopback."""

import json
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from extras import needs
from patience import patience

ROOT = Path(__file__).resolve().parents[1]
TARGET = 'fleet'


def distributed() -> None:
    """Skip the test where Dask's distributed is not installed."""
    needs('distributed', TARGET)


@contextmanager
def cluster(folder: Path, workers: int = 2, **environment: str) -> Iterator[tuple[str, list]]:
    """Start a scheduler, and a process for each worker; give its address, and all processes."""
    file = folder / 'scheduler.json'
    line = ('scheduler', '--host', '127.0.0.1', '--port', '0', '--scheduler-file', str(file))
    started = [_start(folder, *line)]
    try:
        end = time.monotonic() + patience(20.0)
        while not file.exists():
            assert time.monotonic() < end, 'the scheduler does not start'
            time.sleep(0.02)
        address = json.loads(file.read_text())['address']
        started += [worker(folder, address, **environment) for _ in range(workers)]
        yield address, started
    finally:
        for process in reversed(started):
            process.terminate()
        for process in started:
            try:
                process.wait(patience(5.0))
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()


def worker(folder: Path, address: str, **environment: str) -> subprocess.Popen:
    """Start a worker with one thread, and the nanny that replaces its process when it dies."""
    return _start(folder, 'worker', address, '--nthreads', '1', '--host', '127.0.0.1',
                  **environment)  # fmt: skip


def _start(folder: Path, *words: str, **environment: str) -> subprocess.Popen:
    paths = os.pathsep.join((str(ROOT), str(ROOT / 'test')))
    return subprocess.Popen(
        [sys.executable, '-m', 'dask', *words, '--no-dashboard'], cwd=folder,
        env={**os.environ, 'PYTHONPATH': paths, **environment}, stderr=subprocess.DEVNULL,
    )  # fmt: skip
