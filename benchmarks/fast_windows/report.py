"""Tables of windows beside their rollouts."""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from benchmarks.c_twin import LANES, SNR, YARDSTICK
from benchmarks.fast_windows.run import JUMPING, PERIOD, Costs, Row
from benchmarks.intervals import median_interval
from benchmarks.report import Requirement, filled, requirements, table

LIMITS: Mapping[str, float] = {'warm 300': 8.0, 'warm 1000': 4.0, 'cold 1000': 3.5}
JUMP_LIMIT = 2.0  # times the warm window without
AGAINST_LIMIT = 1.05  # times the other tree's


def report(rows: Sequence[Row], pairs: Costs, windows: int) -> str:
    """Return the report."""
    return filled(
        'fast_windows/report',
        windows=windows,
        period=PERIOD,
        snr=f'{SNR:g}',
        lanes=LANES,
        samples=YARDSTICK,
        requirements=requirements([*asked(rows), *beside(pairs)]),
        times=table(
            {
                'windows': row.kind,
                'number': len(row.windows),
                'ms': spread([1e3 * w.seconds for w in row.windows]),
                'candidates': f'{candidates(row):.0f}',
                'limit, ms': f'{np.median([1e3 * w.steps * w.yardstick for w in row.windows]):.2f}',
                'ratio': spread([w.ratio for w in row.windows]),
                'outcomes': outcomes(w.outcome for w in row.windows),
            }
            for row in rows
        ),
        against=against(pairs),
    )


def asked(rows: Sequence[Row]) -> Iterator[Requirement]:
    """Yield what is asked of the ratios."""
    known = {row.kind: row.windows for row in rows}
    for kind, limit in LIMITS.items():
        ratio = float(np.median([w.ratio for w in known[kind]]))
        yield Requirement(f'{kind}: <= {limit:g} x its limit', f'{ratio:.1f}', ratio <= limit)
    plain, jumping = (
        float(np.median([w.seconds for w in known[f'warm {JUMPING}{more}']]))
        for more in ('', ', a jump inside')
    )
    yield Requirement(
        f'with a jump inside: <= {JUMP_LIMIT:g} x the warm window without',
        f'{jumping / plain:.2f}',
        jumping <= JUMP_LIMIT * plain,
    )


def beside(pairs: Costs) -> Iterator[Requirement]:
    """Yield what is asked of windows by themselves beside another tree."""
    for (kind, *_), own in pairs.items():
        if kind.startswith('cold'):
            ratio = float(np.median([pair.ratio for pair in own]))
            asked = f'{kind}: <= {AGAINST_LIMIT:g} x the time of the other tree'
            yield Requirement(asked, f'{ratio:.2f}', ratio <= AGAINST_LIMIT)


def against(pairs: Costs) -> str:
    """Return the table of times beside another tree."""
    if not pairs:
        return 'Not measured: `--against PATH` gives the other tree.'
    return table(
        {
            'windows': kind,
            'number': len(own),
            'ratio': spread([pair.ratio for pair in own]),
            'other outcomes': sum(p.own.outcome != p.other.outcome for p in own),
        }
        for (kind, *_), own in pairs.items()
    )


def candidates(row: Row) -> float:
    """Return the median of candidates that a window rolled out, in whole windows."""
    return float(np.median([w.steps for w in row.windows])) / (
        int(row.kind.split()[1].rstrip(',')) - 1
    )


def spread(values: Sequence[float]) -> str:
    """Return the median with its 95 % interval."""
    middle, low, high = median_interval(values)
    return f'{middle:.2f} ({low:.2f} to {high:.2f})'


def outcomes(found: Iterator[str]) -> str:
    """Return outcomes with their numbers."""
    return ', '.join(f'{count} {outcome}' for outcome, count in Counter(found).most_common())
