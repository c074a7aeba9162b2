"""Tables of the kernel's times."""

from collections.abc import Sequence

import numpy as np

from benchmarks.kernel.run import Pass, Row
from benchmarks.report import Requirement, filled, requirements, table

RATIO_LIMITS = {1: 1.3, 16: 1.2, 32: 1.2, 64: 1.3}  # ours / C, by lanes
ONE_LANE_LIMIT = 1.05  # noise of the measurement; one lane is padded to 16
FILTER_LIMIT = 20.0  # candidate-steps per sample


def report(rows: Sequence[Row], along: Pass, rounds: int) -> str:
    """Return the report."""
    asked = [
        Requirement(
            f'{row.lanes} lanes: ours / C <= {RATIO_LIMITS[row.lanes]}',
            f'{row.ratio:.2f}',
            row.ratio <= RATIO_LIMITS[row.lanes],
        )
        for row in rows
        if np.isfinite(row.ratio)
    ]
    share = rows[0].call / rows[1].call
    one = 'one lane, padded, is not slower than 16'
    asked.append(Requirement(one, f'{share:.2f} times as long', share <= ONE_LANE_LIMIT))
    asked.append(
        Requirement(
            f"filter's pass <= {FILTER_LIMIT:g} candidate-steps per sample",
            f'{along.steps:.1f} ({along.ns:.0f} ns)',
            along.steps <= FILTER_LIMIT,
        )
    )
    none = "filter's pass: no allocation per sample"
    asked.append(Requirement(none, f'{along.allocations} more', along.allocations == 0))
    times = table(
        {
            'lanes': row.lanes,
            'ours (ns)': f'{row.ours:.1f}',
            'C (ns)': f'{row.c:.1f}',
            'NumPy (ns)': f'{row.numpy:.0f}',
            'ours / C': f'{row.ratio:.2f}',
        }
        for row in rows
    )
    return filled('kernel/report', rounds=rounds, times=times, requirements=requirements(asked))
