"""The runs that Yang, Li & Dahhou 2020 print in Tables 1 and 2."""

import csv
import functools
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np

from obs_ros.core.typing import Array

SYMBOLS = ('p1', 'p2', 'p3', 'h3')
# The paper's fitness functions (section 5.1), by the names they have here.
FITNESSES = {'ft1': 'euclidean', 'ft2': 'correlation'}
SNRS = (np.inf, 40.0, 20.0, 0.0, -20.0)  # dB


class Cell(NamedTuple):
    """An experiment: fitness `ft1` or `ft2`, window `T1` to `T3`, noise."""

    fitness: str
    window: str
    snr_db: float


def printed_errors(cell: Cell) -> Array:
    """Return the absolute errors (4,) of p1, p2, p3 (1) and h3 (cm) of the printed run.

    Against the paper's own true values; NaN where it prints no run.
    """
    rows = printed_rows()
    run = rows.get((cell.fitness, cell.window, f'{cell.snr_db:g}'))
    return (
        np.full(len(SYMBOLS), np.nan)
        if run is None
        else np.abs(run - rows['true', cell.window, ''])
    )


@functools.cache
def printed_rows() -> Mapping[tuple[str, str, str], Array]:
    """Return what is printed (4,), by fitness or `true`, window and SNR as text."""
    path = Path(__file__).with_name('reference.csv')
    lines = [line for line in path.read_text().splitlines() if not line.startswith('#')]
    return {
        (row['fitness'], row['window'], row['snr_db']): np.array([float(row[s]) for s in SYMBOLS])
        for row in csv.DictReader(lines)
    }
