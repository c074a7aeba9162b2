"""The runner of benchmarks: options, process time, progress, Monte-Carlo runs on every core."""

import argparse
import functools
import multiprocessing
import os
import shutil
import subprocess
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar

Item = TypeVar('Item')
Key = TypeVar('Key')
Result = TypeVar('Result')

ROOT = Path(__file__).parents[1]
TELL_EVERY = 0.2  # s, between two updates of the line of progress


def options(description: str | None) -> argparse.ArgumentParser:
    """Return a parser with the options that every benchmark has."""
    parser = argparse.ArgumentParser(
        description=description, formatter_class=argparse.ArgumentDefaultsHelpFormatter
    )
    results = Path(__file__).with_name('results')
    parser.add_argument('--results', type=Path, default=results, help='folder for the report')
    return parser


def cpu_seconds(call: Callable[[], object], repeats: int = 1) -> float:
    """Process time of one call in s: others on the machine do not count."""
    begin = time.process_time()
    for _ in range(repeats):
        call()
    return (time.process_time() - begin) / repeats


def timed(call: Callable[[], Result]) -> tuple[Result, float]:
    """Return the result of a call, and its process time in s."""
    found: list[Result] = []
    seconds = cpu_seconds(lambda: found.append(call()))
    return found[0], seconds


def repeats_for(call: Callable[[], object], seconds: float) -> int:
    """Return how often to call so that one measurement lasts `seconds`; the call is warm then."""
    call()
    return max(1, round(seconds / max(cpu_seconds(call), 1e-7)))


def progress(items: Iterable[Item], label: str, total: int) -> Iterator[Item]:
    """Hand the items on; a terminal's line tells how many are done and the time that is left."""
    begin = told = time.monotonic()
    for done, item in enumerate(items, 1):
        yield item
        now = time.monotonic()
        if sys.stderr.isatty() and (done == total or now > told + TELL_EVERY):
            told, spent = now, now - begin
            left = spent / done * (total - done)
            line = f'{label}: {done}/{total}, {spent:.0f} s, {left:.0f} s to go'
            end = '\n' if done == total else ''
            print(f'\r{line:<78}', end=end, file=sys.stderr, flush=True)


def monte_carlo(
    work: Callable[..., Result],
    cells: Mapping[Key, Sequence[tuple[Any, ...]]],
    label: str,
    chunk: int = 1,
) -> dict[Key, list[Result]]:
    """Return by cell the results of `work`, a module's function, in the order of the runs.

    A run is a tuple of arguments, with its seed. Workers take `chunk` of them at a time, from cell
    after cell.
    """
    runs = [run for own in cells.values() for run in own]
    # Every core has its own process: threads of linear algebra would only get in their way.
    os.environ.setdefault('OPENBLAS_NUM_THREADS', '1')
    # Spawned, not forked: a fork would copy the threads' locks of the libraries in use.
    with multiprocessing.get_context('spawn').Pool(max(1, min(cores(), len(runs)))) as pool:
        done = pool.imap(functools.partial(_called, work), runs, chunk)
        results = iter(list(progress(done, label, len(runs))))
    return {key: [next(results) for _ in own] for key, own in cells.items()}


def _called(work: Callable[..., Result], arguments: tuple[Any, ...]) -> Result:
    return work(*arguments)


def cores() -> int:
    """Number of cores that this process may use."""
    return len(os.sched_getaffinity(0))


def gcc_version() -> str | None:
    """Return gcc's version, or None where there is no gcc."""
    if shutil.which('gcc') is None:
        return None
    command = ['gcc', '-dumpfullversion']
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()
