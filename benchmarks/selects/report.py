"""Table of the times of plants that choose."""

from collections.abc import Sequence

from benchmarks.report import Requirement, filled, requirements, table
from benchmarks.selects.run import CANDIDATES, Row

LIMIT = 1.3  # times the plain step


def report(rows: Sequence[Row], rounds: int) -> str:
    """Return the report."""
    worst = max(rows, key=lambda row: row.ratio)
    asked = Requirement(
        f'no plant that chooses takes more than {LIMIT} times its plain one',
        f'{worst.ratio:.2f} ({worst.plant}, {worst.choice})',
        worst.ratio <= LIMIT,
    )
    times = table(
        {
            'plant': row.plant,
            'chooses by': row.choice,
            'plain (ns)': f'{row.plain:.1f}',
            'choosing (ns)': f'{row.ours:.1f}',
            'ratio': f'{row.ratio:.2f}',
        }
        for row in rows
    )
    parts = {'times': times, 'requirements': requirements([asked])}
    return filled('selects/report', candidates=CANDIDATES, rounds=rounds, **parts)
