"""Reports of benchmarks: tables, requirements, pictures, and the machine that measured."""

import datetime
import platform
import re
from collections.abc import Callable, Iterable, Mapping
from importlib import metadata
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from benchmarks.runner import cores
from obs_ros.core.typing import Array

VERSIONS = ('numpy', 'scipy', 'numba', 'llvmlite')


class Requirement(NamedTuple):
    """A thing asked or claimed, the measured value, and whether it meets that."""

    asked: str
    measured: str
    met: bool


def requirements(rows: Iterable[Requirement]) -> str:
    """Return the table of requirements; values are judged as they are, margins excuse nothing."""
    return table(row._asdict() | {'met': 'yes' if row.met else '**no**'} for row in rows)


def table(rows: Iterable[Mapping[str, object]]) -> str:
    """Return a Markdown table of rows that map the head of a column to its cell."""
    rows = list(rows)
    if not rows:
        return 'None.'
    lines = [rows[0], ['---'] * len(rows[0]), *(row.values() for row in rows)]
    return '\n'.join('| ' + ' | '.join(map(str, line)) + ' |' for line in lines)


def quantiles(values: Iterable[float]) -> tuple[float, float]:
    """Return median and 95th percentile."""
    median, high = np.quantile(list(values), (0.5, 0.95))
    return float(median), float(high)


def rms(values: Array, axis: int | None = None) -> Any:
    """Return the root mean square, over all values or along an axis."""
    return np.sqrt(np.mean(np.asarray(values) ** 2, axis=axis))


def slashed(values: Iterable[float], form: str = '.2f') -> str:
    """Return figures that belong together, as text."""
    return ' / '.join(format(float(value), form) for value in values)


def panels(rows: int, columns: int, size: tuple[float, float], **shared: Any) -> tuple[Any, Any]:
    """Return a figure of `size` (inches) and its axes (rows, columns)."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=size, layout='constrained')
    return figure, figure.subplots(rows, columns, squeeze=False, **shared)


def pictures(folder: Path, drawn: Mapping[str, tuple[str, Callable[[], Any]]]) -> str:
    """Save figures by file name, each with its title; return the Markdown that shows them.

    Without Matplotlib it says so.
    """
    folder.mkdir(parents=True, exist_ok=True)
    try:
        for name, (_, draw) in drawn.items():
            draw().savefig(folder / name, dpi=110)
    except ImportError as error:
        return f'No pictures: {error}.'
    return '\n\n'.join(f'![{title}]({name})' for name, (title, _) in drawn.items())


def filled(template: str, **parts: object) -> str:
    """Return the text of `benchmarks/<template>.md` with its places filled; empty ones close up."""
    path = Path(__file__).parent / f'{template}.md'
    text = path.read_text(encoding='utf-8').format(**parts)
    return re.sub(r'\n{3,}', '\n\n', text).strip()


def publish(folder: Path, name: str, title: str, text: str, *machine: str) -> str:
    """Print a report, with date, processor and versions, and write it to `folder/name.md`.

    `machine` are further facts about it. Return the whole text.
    """
    facts = [
        datetime.date.today().isoformat(),
        f'{cpu_model()} ({cores()} cores)',
        f'Python {platform.python_version()}',
        *versions(VERSIONS),
        *machine,
    ]
    text = '\n\n'.join([f'# {title}', ', '.join(facts), text]) + '\n'
    print(text)
    folder.mkdir(parents=True, exist_ok=True)
    (folder / f'{name}.md').write_text(text, encoding='utf-8')
    return text


def versions(packages: Iterable[str]) -> list[str]:
    """Return each package with its version, or that there is none."""
    found = []
    for name in packages:
        try:
            found.append(f'{name} {metadata.version(name)}')
        except metadata.PackageNotFoundError:
            found.append(f'no {name}')
    return found


def cpu_model() -> str:
    """Return the processor's name, with family and model: cloud machines hide the rest."""
    try:
        lines = Path('/proc/cpuinfo').read_text().splitlines()
    except OSError:
        return platform.processor() or platform.machine()
    facts = dict((part.strip() for part in line.split(':', 1)) for line in lines if ':' in line)
    name = facts.get('model name', platform.machine())
    return f'{name} family {facts.get("cpu family", "?")} model {facts.get("model", "?")}'
