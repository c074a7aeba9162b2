"""Tables of the starts and ends."""

from collections.abc import Sequence

import numpy as np

from benchmarks.coming_and_going.run import Stay
from benchmarks.report import Requirement, requirements, table

LIMITS = {'start': 2.0, 'stop': 1.0}  # s, of the medians


def report(stays: Sequence[Stay]) -> list[str]:
    """Return the parts of the report."""
    seconds = {name: np.array([getattr(each, name) for each in stays]) for name in LIMITS}
    medians = {name: float(np.median(values)) for name, values in seconds.items()}
    fine = sum(each.code == 0 and each.quiet for each in stays)
    cpu = float(np.median([each.cpu for each in stays]))
    return [
        f'{len(stays)} starts. Start: from the process to the first subscription; stop: from '
        'SIGINT to the exit.',
        table(
            {
                '': name,
                'fastest (s)': f'{values.min():.2f}',
                'median (s)': f'{medians[name]:.2f}',
                'slowest (s)': f'{values.max():.2f}',
            }
            for name, values in seconds.items()
        ),
        f'Process time until the subscription: {cpu:.2f} s (median).',
        requirements([
            *(
                Requirement(f'{name}: median <= {limit:g} s', f'{medians[name]:.2f} s',
                            medians[name] <= limit)
                for name, limit in LIMITS.items()
            ),
            Requirement('exit code 0 and no traceback, every time', f'{fine} of {len(stays)}',
                        fine == len(stays)),
        ]),
    ]  # fmt: skip
