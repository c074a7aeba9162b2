"""Table of the starts, and their ratios to the imports alone."""

from collections.abc import Mapping, Sequence

import numpy as np

from benchmarks.intervals import median_interval
from benchmarks.report import Requirement, filled, requirements, table
from benchmarks.start_up.run import PHASES, Start
from obs_ros.core.typing import Array

LIMITS = {'warm': 2.0, 'cold': 8.0}  # times the imports


def report(starts: Mapping[str, Sequence[Start]]) -> str:
    """Return the report."""
    cpu = {kind: np.array([start['cpu'] for start in own]) for kind, own in starts.items()}
    seconds = table(
        {
            'process': kind,
            'starts': len(own),
            'process time (s)': spread(cpu[kind]),
            'wall (s)': f'{np.median([start["wall"] for start in own]):.2f}',
            **{
                f'{phase} (s)': '' if np.isnan(own[0][phase])
                else f'{np.median([start[phase] for start in own]):.2f}'
                for phase in PHASES
            },
        }
        for kind, own in starts.items()
    )  # fmt: skip
    asked = []
    for kind, limit in LIMITS.items():
        ratio = cpu[kind] / cpu['imports']
        met = bool(np.median(ratio) <= limit)
        asked.append(Requirement(f'{kind}: <= {limit:g} x the imports', spread(ratio), met))
    return filled('start_up/report', seconds=seconds, requirements=requirements(asked))


def spread(values: Array) -> str:
    """Return the median with its 95 % interval."""
    middle, low, high = median_interval(values.tolist())
    return f'{middle:.2f} ({low:.2f} to {high:.2f})'
