"""What all benchmarks share: process time, progress, work on every core, reports."""

import argparse
import datetime
import multiprocessing
import os
import platform
import shutil
import subprocess
import sys
import time
from collections.abc import Callable, Iterable, Sequence
from importlib import metadata
from pathlib import Path
from typing import TypeVar

import numpy as np

Item = TypeVar('Item')
Result = TypeVar('Result')

RESULTS = Path(__file__).parent / 'results'


def options(description: str | None) -> argparse.ArgumentParser:
    """Return a parser with the options that every benchmark has."""
    parser = argparse.ArgumentParser(
        description=description, formatter_class=argparse.ArgumentDefaultsHelpFormatter
    )
    parser.add_argument('--results', type=Path, default=RESULTS, help='folder for the report')
    return parser


def cpu_seconds(call: Callable[[], object], repeats: int = 1) -> float:
    """Process time of one call in s: others on the machine do not count."""
    begin = time.process_time()
    for _ in range(repeats):
        call()
    return (time.process_time() - begin) / repeats


def repeats_for(call: Callable[[], object], seconds: float) -> int:
    """Return how often to call so that one measurement lasts `seconds`; the call is warm then."""
    call()
    return max(1, round(seconds / max(cpu_seconds(call), 1e-7)))


class Progress:
    """One line on stderr: rewritten on a terminal, else a new one every tenth of the way."""

    def __init__(self, label: str, total: int) -> None:
        self.label = label
        self.total = total
        self.done = 0
        self.begin = time.monotonic()
        self.live = sys.stderr.isatty()

    def step(self) -> None:
        """Count one more as done."""
        self.done += 1
        tenth = self.done * 10 // self.total > (self.done - 1) * 10 // self.total
        if not (self.live or tenth):
            return
        spent = time.monotonic() - self.begin
        left = spent / self.done * (self.total - self.done)
        line = f'{self.label}: {self.done}/{self.total}, {spent:.0f} s, {left:.0f} s to go'
        last = self.done == self.total
        print(
            f'\r{line:<78}' if self.live else line,
            end='\n' if last or not self.live else '',
            file=sys.stderr,
            flush=True,
        )


def on_all_cores(
    work: Callable[[Item], Result], items: Sequence[Item], label: str, chunk: int = 1
) -> list[Result]:
    """Return the results of `work`, a module's function, in the order of the items."""
    progress, results = Progress(label, len(items)), []
    # Every core has its own process: threads of linear algebra would only get in their way.
    os.environ.setdefault('OPENBLAS_NUM_THREADS', '1')
    # Spawned, not forked: a fork would copy the threads' locks of the libraries in use.
    with multiprocessing.get_context('spawn').Pool(min(cores(), len(items))) as pool:
        for result in pool.imap(work, items, chunk):
            results.append(result)
            progress.step()
    return results


def cores() -> int:
    """Number of cores that this process may use."""
    return len(os.sched_getaffinity(0))


def table(head: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """Return a Markdown table."""
    lines = [head, ['---'] * len(head), *rows]
    return '\n'.join('| ' + ' | '.join(str(cell) for cell in line) + ' |' for line in lines)


def mark(holds: bool) -> str:
    """Return how an acceptance is told."""
    return 'yes' if holds else '**no**'


def quantiles(values: Iterable[float]) -> tuple[float, float]:
    """Return median and 95th percentile."""
    median, high = np.quantile(list(values), (0.5, 0.95))
    return float(median), float(high)


def machine(*extra: str) -> str:
    """Return date, processor and versions, in one line."""
    packages = []
    for name in ('numpy', 'scipy', 'numba', 'llvmlite'):
        try:
            packages.append(f'{name} {metadata.version(name)}')
        except metadata.PackageNotFoundError:
            packages.append(f'no {name}')
    return ', '.join(
        [
            datetime.date.today().isoformat(),
            f'{cpu_model()} ({cores()} cores)',
            f'Python {platform.python_version()}',
            *packages,
            *extra,
        ]
    )


def cpu_model() -> str:
    """Return the processor's name, with family and model: cloud machines hide the rest."""
    try:
        lines = Path('/proc/cpuinfo').read_text().splitlines()
    except OSError:
        return platform.processor() or platform.machine()
    facts = dict((part.strip() for part in line.split(':', 1)) for line in lines if ':' in line)
    name = facts.get('model name', platform.machine())
    return f'{name} family {facts.get("cpu family", "?")} model {facts.get("model", "?")}'


def gcc_version() -> str | None:
    """Return gcc's version, or None where there is no gcc."""
    if shutil.which('gcc') is None:
        return None
    return subprocess.run(
        ['gcc', '-dumpfullversion'], capture_output=True, text=True, check=True
    ).stdout.strip()


def publish(folder: Path, name: str, title: str, parts: Sequence[str], machine_line: str) -> str:
    """Print a report and write it to `folder/name.md`; return its text."""
    text = '\n\n'.join([f'# {title}', machine_line, *parts]) + '\n'
    print(text)
    folder.mkdir(parents=True, exist_ok=True)
    (folder / f'{name}.md').write_text(text, encoding='utf-8')
    return text


def holds(claim: bool) -> str:
    """Return how a claim is judged."""
    return 'holds' if claim else '**does not hold**'
