"""The printed runs of Tables 1 and 2, and an independent implementation's 95th percentiles."""

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


class Reference(NamedTuple):
    """Absolute errors (4,) of p1, p2, p3 (1) and h3 (cm); `run` is NaN where the paper has none."""

    p95: Array
    run: Array


@functools.cache
def references() -> Mapping[Cell, Reference]:
    """Read the reference; see the file for where it comes from."""
    path = Path(__file__).with_name('reference.csv')
    lines = [line for line in path.read_text().splitlines() if not line.startswith('#')]
    return {
        Cell(row['fitness'], row['window'], float(row['snr_db'])): Reference(
            *(
                np.array([float(row[f'{kind}_{symbol}'] or 'nan') for symbol in SYMBOLS])
                for kind in Reference._fields
            )
        )
        for row in csv.DictReader(lines)
    }
