"""Tables of the times and errors of functions."""

from collections.abc import Sequence

import numpy as np

from benchmarks.functions.accuracy import RANGES, Error
from benchmarks.functions.compilation import Compilation
from benchmarks.functions.run import CANDIDATES, SAMPLES, Row
from benchmarks.report import Requirement, filled, requirements, table

WORST = 3.0  # units in the last place, beside what is asked: 1e-12 of the value
BEYOND = 'huge'  # range in which angles are NaN
ANGLES = ('sin', 'cos', 'tan')
GROWTH = 1.1  # of the time of the first compilation


def report(
    rows: Sequence[Row], accuracy: Sequence[Error], compiled: Sequence[Compilation], rounds: int
) -> str:
    """Return the report."""
    return filled(
        'functions/report',
        candidates=CANDIDATES,
        samples=SAMPLES,
        rounds=rounds,
        times=table(map(_time, rows)),
        errors=table(map(_error, accuracy)),
        compilations=table(map(_compilation, compiled)),
        requirements=requirements(asked(rows, accuracy, compiled)),
    )


def asked(
    rows: Sequence[Row], accuracy: Sequence[Error], compiled: Sequence[Compilation]
) -> list[Requirement]:
    """Return what is asked of each function, and whether it is met."""
    found = [
        Requirement(
            f'{row.name} ({row.method}) <= {row.limit:g} times the plain spring',
            f'{row.ratio:.2f}',
            row.ratio <= row.limit,
        )
        for row in rows
        if np.isfinite(row.limit)
    ]
    if accuracy:
        error, name = max(
            (value, each.name)
            for each in accuracy
            for kind, value in each.by_range.items()
            if np.isfinite(value)
        )
        text = f'errors <= {WORST:g} units in the last place'
        found.append(Requirement(text, f'{error:.2f} ({name})', error <= WORST))
        lost = [each.name for each in accuracy if not np.isfinite([*each.by_range.values()]).all()]
        text = 'no finite value is NaN'
        found.append(Requirement(text, ', '.join(lost) or 'none', not lost))
    for each in compiled:
        if np.isfinite(each.theirs):
            ratio = each.ours / each.theirs
            text = f'first compilation of {each.model} <= {GROWTH} times the other tree'
            found.append(Requirement(text, f'{ratio:.2f}', ratio <= GROWTH))
    return found


def _time(row: Row) -> dict[str, str]:
    return {
        'friction': row.name,
        'steps': row.method,
        'ours (ns)': _figure(row.ours),
        'ours / plain': f'{row.ratio:.2f} ({row.low:.2f}-{row.high:.2f})',
        'C (ns)': _figure(row.c),
        'C -ffast-math (ns)': _figure(row.fast),
        'other tree (ns)': _figure(row.theirs),
    }


def _error(row: Error) -> dict[str, str]:
    return {'function': row.name} | {kind: _figure(row.by_range[kind]) for kind in RANGES}


def _compilation(row: Compilation) -> dict[str, str]:
    return {
        'model': row.model,
        'ours (s)': _figure(row.ours),
        'other tree (s)': _figure(row.theirs),
    }


def _figure(value: float) -> str:
    return f'{value:.2f}' if np.isfinite(value) else '-'
