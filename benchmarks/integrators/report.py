"""Rows and tables of integration without a step that anyone chose."""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from benchmarks.integrators.cost import Costs
from benchmarks.integrators.curves import Point
from benchmarks.integrators.filters import Followed
from benchmarks.integrators.kinks import Kinked
from benchmarks.integrators.run import Solved
from benchmarks.intervals import median_interval, share_interval
from benchmarks.report import Requirement, table

OPTIMAL = 0.98  # of the windows, pooled
MILD = 10.0  # times the process time of a plant that is not stiff
SLOWER = 1.05  # times that of the other tree
COVERED = 0.93, 0.97
ERROR = 0.3  # deviations of the noise
FAR = 0.3  # deviations of a filter
SHOWN = 1e-3  # error of the rows of a curve


def rows(
    windows: Mapping[str, Sequence[Solved]],
    kinks: Sequence[Kinked],
    filters: Sequence[Followed],
    costs: Costs,
) -> Iterator[Requirement]:
    """Yield the rows of what was measured."""
    every = [one for own in windows.values() for one in own]
    if every:
        hits = sum(one.at_the_optimum for one in every)
        yield Requirement(
            f'windows at the optimum, pooled >= {OPTIMAL:g}', share(hits, len(every)),
            hits >= OPTIMAL * len(every),
        )  # fmt: skip
        worst = max(windows, key=lambda name: slowness(windows[name])[0])
        slow = slowness(windows[worst])
        yield Requirement(
            f'process time <= {MILD:g} x that of a mild plant', f'{spread(*slow)} ({worst})',
            slow[1] <= MILD,
        )  # fmt: skip
        errors = [(one.error, one.plant) for one in every if np.isfinite(one.error)]
        largest, plant = max(errors, default=(np.nan, 'none accepted'))
        over = sum(error > ERROR for error, _ in errors)
        yield Requirement(
            f'error of integration of every accepted answer <= {ERROR:g} sd',
            f'{over} of {len(errors)} above; at most {largest:.2g} ({plant})', not over,
        )  # fmt: skip
    if kinks:
        given = [one for one in kinks if one.given]
        hits = sum(one.covered for one in given)
        yield Requirement(
            f'kinked tanks at 60 dB: coverage of p1 {COVERED[0]:g}-{COVERED[1]:g}',
            f'{share(hits, len(given))}; given in {len(given)} of {len(kinks)}',
            bool(given) and COVERED[0] <= hits / len(given) <= COVERED[1],
        )
    if filters:
        far = max(filters, key=lambda one: one.difference)
        yield Requirement(
            f'filters within {FAR:g} deviations of fine steps',
            f'at most {far.difference:.2g} ({far.filter}, {far.plant})', far.difference <= FAR,
        )  # fmt: skip
    if pairs := [pair for own in costs.values() for pair in own]:
        median, low, high = median_interval([pair.ratio for pair in pairs])
        yield Requirement(
            f'three tanks and zoo: time <= {SLOWER:g} x the other tree',
            spread(median, low, high), low <= SLOWER,
        )  # fmt: skip


def share(hits: int, count: int) -> str:
    """Return a share with its interval, in words."""
    if not count:
        return 'none'
    low, high = share_interval(hits, count)
    return f'{hits / count:.3f} ({low:.3f}-{high:.3f}) of {count}'


def spread(median: float, low: float, high: float) -> str:
    """Return a median with its interval, in words."""
    return f'{median:.2f} ({low:.2f}-{high:.2f})'


def slowness(own: Sequence[Solved]) -> tuple[float, float, float]:
    """Return the process time of a plant's windows in that of its mild twin's."""
    ratios = [one.seconds / one.mild for one in own if np.isfinite(one.mild)]
    return median_interval(ratios) if ratios else (np.nan,) * 3


def plants(windows: Mapping[str, Sequence[Solved]]) -> str:
    """Return the table of the plants."""
    return table(
        {
            'plant': name,
            'at the optimum': f'{sum(one.at_the_optimum for one in own)} of {len(own)}',
            'outcomes': outcomes(one.outcome for one in own),
            'greatest error, sd': f'{np.nanmax([one.error for one in own] + [-1.0]):.2g}',
            'told, sd': f'{np.nanmax([one.claimed for one in own] + [-1.0]):.2g}',
            'ms': f'{1e3 * np.median([one.seconds for one in own]):.1f}',
            'of a mild one': spread(*slowness(own)),
        }
        for name, own in windows.items()
    )


def outcomes(found: Iterator[str]) -> str:
    """Return outcomes with their numbers."""
    return ', '.join(f'{count} {outcome}' for outcome, count in Counter(found).most_common())


def failures(windows: Mapping[str, Sequence[Solved]]) -> str:
    """Return the list of windows that are not at the optimum, or err too much."""
    lines = [
        f'- {name}, window {i}: {one.outcome}, squares {one.excess:.3g} above the optimum, '
        f'integration error {one.error:.2g} sd'
        for name, own in windows.items()
        for i, one in enumerate(own)
        if not one.at_the_optimum or one.error > ERROR
    ]
    return '\n'.join(lines)


def curves(points: Sequence[Point]) -> str:
    """Return the table of the cheapest rows with a small error, by plant and method."""
    found = []
    for key in dict.fromkeys((point.plant, point.method) for point in points):
        good = [p for p in points if (p.plant, p.method) == key and p.error < SHOWN]
        best = min(good, key=lambda point: point.nanoseconds, default=None)
        found.append({
            'plant': key[0], 'method': key[1],
            'steps a sample, or tolerance': f'{best.how:g}' if best else 'none is enough',
            'ns a sample': f'{best.nanoseconds:.3g}' if best else '',
            'error': f'{best.error:.1g}' if best else '',
        })  # fmt: skip
    return table(found)


def filter_table(filters: Sequence[Followed]) -> str:
    """Return the table of the filters."""
    names = dict.fromkeys((one.plant, one.filter) for one in filters)
    return table(
        {
            'plant': plant,
            'filter': name,
            'greatest difference, deviations': f'{max(own):.2g}',
        }
        for plant, name in names
        if (own := [o.difference for o in filters if (o.plant, o.filter) == (plant, name)])
    )


def cost(costs: Costs) -> str:
    """Return the table of times beside another tree."""
    if not costs:
        return 'Not measured: `--against PATH` gives the other tree.'
    return table(
        {
            'case': case,
            'windows': len(own),
            'ratio': spread(*median_interval([pair.ratio for pair in own])),
            'same bits': f'{sum(pair.same for pair in own)} of {len(own)}',
            'ms': f'{1e3 * np.median([pair.own.seconds for pair in own]):.1f}',
        }
        for (case,), own in costs.items()
    )
