"""Table of the times of plants that choose."""

from collections.abc import Sequence

from benchmarks.report import Requirement, requirements, table
from benchmarks.selects.run import CANDIDATES, Row

LIMIT = 1.3  # times the plain step


def report(rows: Sequence[Row], rounds: int) -> list[str]:
    """Return the parts of the report."""
    worst = max(rows, key=lambda row: row.ratio)
    asked = Requirement(
        f'no plant that chooses takes more than {LIMIT} times its plain one',
        f'{worst.ratio:.2f} ({worst.plant}, {worst.choice})',
        worst.ratio <= LIMIT,
    )
    return [
        'Process time per candidate and RK4 step with the squared residuals of the outputs, of '
        f'{CANDIDATES} candidates; the fastest of {rounds} interleaved measurements, the ratio '
        'being the median of their ratios. The plain plant has the same terms, linear instead of '
        'chosen. Each was checked against NumPy (rtol 1e-9).',
        table(
            {
                'plant': row.plant,
                'chooses by': row.choice,
                'plain (ns)': f'{row.plain:.1f}',
                'choosing (ns)': f'{row.ours:.1f}',
                'ratio': f'{row.ratio:.2f}',
            }
            for row in rows
        ),
        requirements([asked]),
    ]
