"""Tables of the observers' costs and of the valves that they find."""

from collections.abc import Sequence

import numpy as np

from benchmarks.observer_costs.run import Cost, Valves
from benchmarks.report import Requirement, table

RIGHT = 0.02  # of an opening
MOST = {'ekf': 20.0, 'ukf': 60.0, 'gase': 1000.0}  # us asked to absorb a sample


def costs_table(costs: Sequence[Cost]) -> str:
    """Tell process times; the sliding window's is that of one solve, and absorbing beside it."""
    return table(
        {
            'observer': one.observer,
            'scenario': one.scenario,
            'absorb (us)': f'{one.absorb:.1f}',
            'with an estimate (us)': f'{one.estimate:.0f}',
            'estimates per sample': f'{one.due:.2f}',
        }
        for one in costs
    )


def asked(costs: Sequence[Cost]) -> list[Requirement]:
    """Judge the times to absorb: filters with six joint states, 1 kHz of the genetic estimator."""
    return [
        Requirement(
            f'{one.observer}: absorb, median <= {MOST[one.observer]:g} us',
            f'{one.absorb:.1f} us',
            one.absorb <= MOST[one.observer],
        )
        for one in costs
        if one.observer in MOST
    ]


def valves_table(found: Sequence[Valves], seeds: int) -> str:
    """Tell the errors of valves that have stood for 1000 s, and the share within 2 sd."""
    rows = []
    for name, errors, sd in found:
        within = (errors <= 2.0 * sd)[np.isfinite(sd)]
        rows.append(
            {
                'observer': name,
                'seeds': seeds,
                f'right within {RIGHT}': f'{np.mean(errors <= RIGHT):.2f}',
                'median error': f'{np.median(errors):.3f}',
                'largest': f'{errors.max():.3f}',
                'within 2 sd': f'{within.mean():.2f}' if within.size else '-',
            }
        )
    return table(rows)
