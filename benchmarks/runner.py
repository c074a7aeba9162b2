"""The runner of benchmarks: options, process time, progress, Monte Carlo on Dask."""

import argparse
import importlib.util
import os
import shutil
import subprocess
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, ClassVar, TypeVar

Item = TypeVar('Item')
Key = TypeVar('Key')
Result = TypeVar('Result')

ROOT = Path(__file__).parents[1]


def options(description: str | None, *, shared: bool = False) -> argparse.ArgumentParser:
    """Return a parser with the options that every benchmark has, or each that is `shared` out.

    The place of their runs is then kept for `monte_carlo`.
    """
    parser = argparse.ArgumentParser(
        description=description, formatter_class=argparse.ArgumentDefaultsHelpFormatter
    )
    results = Path(__file__).with_name('results')
    parser.add_argument('--results', type=Path, default=results, help='folder for the report')
    _Place.chosen.clear()
    if shared:
        parser.add_argument('--jobs', type=int, action=_Place, help='processes (default: cores)')
        parser.add_argument('--scheduler', action=_Place, help='a Dask scheduler, tcp://host:port')
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
    # Imported only now: another source tree, whose package is measured, may not have it.
    from obs_ros.studies.progress import progress as shown

    return shown(items, label, total)


class _Place(argparse.Action):
    """Keeps the place of Monte-Carlo runs, which are made far below the command."""

    chosen: ClassVar[dict[str, Any]] = {}

    def __call__(self, parser: Any, namespace: Any, value: Any, option: str | None = None) -> None:
        self.chosen[self.dest] = value


def monte_carlo(
    work: Callable[..., Result],
    cells: Mapping[Key, Sequence[tuple[Any, ...]]],
    label: str,
    chunk: int = 1,
) -> dict[Key, list[Result]]:
    """Return by cell the results of `work`, a module's function, in the order of the runs.

    A run is a tuple of arguments, with its seed. They are done where the command says, by default
    on every core; workers take `chunk` of them at a time, from cell after cell.

    One that is stopped tells how many runs are done.

    Raises RuntimeError for a run that raises, and as `obs_ros.studies.runner.carried_out` does.
    """
    from obs_ros.studies.runner import Failure, Where, carried_out

    chosen = _Place.chosen
    if not chosen and importlib.util.find_spec('distributed') is None:
        print(f'{label}: in one process, as distributed is missing: make fleet', file=sys.stderr)
    elif not chosen:
        chosen = {'jobs': cores()}
    runs = [run for own in cells.values() for run in own]
    results: dict[int, Any] = {}

    def say(line: str) -> None:
        print(f'{label}: {line}', file=sys.stderr)

    done = carried_out(work, runs, Where(**chosen), chunk, say)
    try:
        for index, result in progress(done, label, len(runs)):
            if isinstance(result, Failure):
                raise RuntimeError(result.details or result.words)
            results[index] = result
    except KeyboardInterrupt:
        say(f'stopped after {len(results)} of {len(runs)} runs')
        raise
    in_order = (results[index] for index in range(len(runs)))
    return {key: [next(in_order) for _ in own] for key, own in cells.items()}


def cores() -> int:
    """Number of cores that this process may use."""
    return len(os.sched_getaffinity(0))


def gcc_version() -> str | None:
    """Return gcc's version, or None where there is no gcc."""
    if shutil.which('gcc') is None:
        return None
    command = ['gcc', '-dumpfullversion']
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()
