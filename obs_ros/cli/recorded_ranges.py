"""How far the signals of a plant move, and how often they are sampled: measured, or assumed."""

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from obs_ros.cli.package_signals import Signals
from obs_ros.core.model import Model, Variable
from obs_ros.core.typing import Array
from obs_ros.replay.recording import TABLE_SUFFIXES, check_file
from obs_ros.replay.table import Table, read_header

STILL = 1e-9  # of its value: what a signal moves less than that is rounding
TINY = 1e-100  # of any unit: as good as 0
HUGE = 1e100  # of any unit: beyond it, ratios and bounds are no numbers
SHORTEST = 0.002  # s of a recording: the shortest window is half of that
FEWEST = 20  # rows of a table, from which a window and a period can be told


@dataclass(frozen=True)
class Range:
    """The lowest, the highest and the mean value of a signal, in its unit."""

    low: float
    high: float
    mean: float

    @property
    def span(self) -> float:
        """The distance of the ends; of a signal that never moves the size of its value, or 1."""
        moved, size = self.high - self.low, max(abs(self.low), abs(self.high))
        if moved > max(STILL * size, TINY):
            return moved
        return size if size > TINY else 1.0


@dataclass(frozen=True)
class Ranges:
    """Ranges of inputs and outputs, in their order, `period` and `duration` in s.

    Raises ValueError for a duration in which no window fits.
    """

    inputs: tuple[Range, ...]
    outputs: tuple[Range, ...]
    period: float
    duration: float

    def __post_init__(self) -> None:
        if self.duration < SHORTEST:
            raise ValueError(f'record for longer: windows have {0.5 * SHORTEST:g} s at least, and '
                             f'all is over in {self.duration:g} s')  # fmt: skip


def assumed(signals: Signals, period: float | None) -> Ranges:
    """Return what stands in for a recording: -10 to 10 for 100 s, or 1000 samples of a period."""
    period = 0.1 if period is None else period
    anywhere = Range(-10.0, 10.0, 0.0)
    inputs, outputs = ((anywhere,) * len(g) for g in (signals.inputs, signals.outputs))
    return Ranges(inputs, outputs, period, 1000.0 * period)


def header_of(path: Path) -> list[str]:
    """Return the names of a table's columns; raises ValueError or OSError for what is no table."""
    check_file(path)
    if path.suffix.lower() not in TABLE_SUFFIXES or not path.is_file():
        raise ValueError(f'give a table, which ends in {" or ".join(TABLE_SUFFIXES)}: {path} '
                         'is none')  # fmt: skip
    header, _ = read_header(path)
    if header == ['']:
        raise ValueError(f'give a table whose first row names its columns: {path} is empty')
    return header


def recorded(path: Path, signals: Signals, period: float | None) -> Ranges:
    """Return what a table shows, read row by row as `replay` reads it.

    Only rows newer than all before them count, so that no table is too long for the memory. Raises
    ValueError, with file and line, for what cannot be read, and for less than 20 such rows.
    """
    table = Table(path, signals.columns, period, _reader(signals))
    u, y = _Extent(len(signals.inputs)), _Extent(len(signals.outputs))
    count, first, newest = 0, math.inf, -math.inf  # ns
    for sample in table:
        count += sample.stamp > newest
        first, newest = min(first, sample.stamp), max(newest, sample.stamp)
        if sample.u is not None:
            u.add(sample.u)
        if sample.y is not None:
            y.add(sample.y)
    if count < FEWEST:
        raise ValueError(f'record more, in order of time: {path} has {count} rows whose time goes '
                         f'on, and less than {FEWEST} tell nothing')  # fmt: skip
    duration = (newest - first) / 1e9
    named = (*zip(signals.inputs, u.ranges(), strict=True),
             *zip(signals.outputs, y.ranges(), strict=True))  # fmt: skip
    for signal, extent in named:
        if extent is None:
            raise ValueError(f'leave {signal.name} out: {path} has no value of it')
        if not max(abs(extent.low), abs(extent.high)) < HUGE:
            raise ValueError(f'give {signal.name} another unit, or leave it out: in {path} it goes '
                             f'from {extent.low:g} to {extent.high:g}')  # fmt: skip
    inputs, outputs = (tuple(r for r in e.ranges() if r is not None) for e in (u, y))
    return Ranges(inputs, outputs, duration / (count - 1), duration)


class _Extent:
    """Lowest, highest and mean value of each column, whose numbers may be NaN."""

    def __init__(self, columns: int) -> None:
        self._low, self._high = np.full(columns, math.inf), np.full(columns, -math.inf)
        self._total, self._count = np.zeros(columns), np.zeros(columns)

    @np.errstate(over='ignore')  # what is so large is refused
    def add(self, values: Array) -> None:
        known = np.isfinite(values)
        self._low = np.fmin(self._low, np.where(known, values, math.inf))
        self._high = np.fmax(self._high, np.where(known, values, -math.inf))
        self._total += np.where(known, values, 0.0)
        self._count += known

    def ranges(self) -> list[Range | None]:
        return [
            Range(float(low), float(high), float(total / count)) if count else None
            for low, high, total, count in zip(
                self._low, self._high, self._total, self._count, strict=True
            )
        ]


def _reader(signals: Signals) -> Model:
    """Return a model that does nothing but name the columns."""
    inputs, outputs = (
        tuple(Variable(each.name) for each in group) for group in (signals.inputs, signals.outputs)
    )
    still = (0.0,) * len(outputs)
    return Model(
        'table', states=outputs, outputs=outputs, inputs=inputs,
        dynamics=lambda t, x, u, p: still, output=lambda t, x, u, p: still,
    )  # fmt: skip
