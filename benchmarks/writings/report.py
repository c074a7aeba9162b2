"""Table of the times of one plant, written in many ways."""

from collections.abc import Sequence

from benchmarks.report import Requirement, filled, requirements, table
from benchmarks.writings.run import CANDIDATES, Row

LIMIT = 1.3  # times the plant in scalars


def report(rows: Sequence[Row], rounds: int) -> str:
    """Return the report."""
    worst = max(rows, key=lambda row: row.ratio)
    asked = Requirement(
        f'no way of writing takes more than {LIMIT} times that of scalars and a tuple returned',
        f'{worst.ratio:.2f} ({worst.backend}, {worst.writing})',
        worst.ratio <= LIMIT,
    )
    times = table(
        {
            'backend': row.backend,
            'written with': row.writing,
            'ns': f'{row.ours:.1f}',
            'ratio': f'{row.ratio:.2f}',
        }
        for row in rows
    )
    parts = {'times': times, 'requirements': requirements([asked])}
    return filled('writings/report', candidates=CANDIDATES, rounds=rounds, **parts)
