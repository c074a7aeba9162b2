"""Tables of the starts and ends."""

from collections.abc import Sequence

import numpy as np

from benchmarks.coming_and_going.run import Stay
from benchmarks.report import Requirement, filled, requirements, table

LIMITS = {'start': 2.0, 'stop': 1.0}  # s, of the medians


def report(stays: Sequence[Stay]) -> str:
    """Return the report."""
    seconds = {name: np.array([getattr(each, name) for each in stays]) for name in LIMITS}
    medians = {name: float(np.median(values)) for name, values in seconds.items()}
    fine = sum(each.code == 0 and each.quiet for each in stays)
    cpu = float(np.median([each.cpu for each in stays]))
    rows = table(
        {
            '': name,
            'fastest (s)': f'{values.min():.2f}',
            'median (s)': f'{medians[name]:.2f}',
            'slowest (s)': f'{values.max():.2f}',
        }
        for name, values in seconds.items()
    )
    asked = [
        *(
            Requirement(f'{name}: median <= {limit:g} s', f'{middle:.2f} s', middle <= limit)
            for (name, limit), middle in zip(LIMITS.items(), medians.values(), strict=True)
        ),
        Requirement(
            'exit code 0 and no traceback, every time',
            f'{fine} of {len(stays)}',
            fine == len(stays),
        ),
    ]
    parts = {'seconds': rows, 'requirements': requirements(asked)}
    return filled('coming_and_going/report', starts=len(stays), cpu=cpu, **parts)
