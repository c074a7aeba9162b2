"""Tables of windows with process noise: coverage, errors, outcomes, time."""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence

import numpy as np
from scipy.stats import beta

from benchmarks.intervals import covered
from benchmarks.process_noise.run import Solved
from benchmarks.report import Requirement, rms, slashed, table

LOW, HIGH = 0.93, 0.97  # of intervals of 95 %
END_LOW, END_HIGH = 0.90, 0.98  # of those of end states

Cells = Mapping[tuple[str, float, str], Sequence[Solved]]


def results(cells: Cells) -> str:
    """Tell coverage, errors and outcomes of each cell."""
    rows = []
    for (name, walk, mode), own in cells.items():
        outcomes = Counter(one.outcome for one in own)
        rows.append(
            {
                'plant': name,
                'walk': f'{walk:g}',
                'process_noise': mode,
                'coverage of parameters': slashed(_share(own, 'error', 'sd')),
                'of the end state': slashed(_share(own, 'end_error', 'end_sd')),
                'RMS error': slashed(rms([one.error for one in own], axis=0), '.4f'),
                'withheld': f'{np.mean([np.isnan(one.sd).any() for one in own]):.2f}',
                'outcomes': ', '.join(f'{key} {count}' for key, count in outcomes.most_common()),
                'ms': f'{1e3 * np.median([one.seconds for one in own]):.0f}',
            }
        )
    return table(rows)


def acceptance(cells: Cells) -> Iterator[Requirement]:
    """Yield, for every cell with `auto`, whether its 95 % intervals meet what is asked."""
    for (name, walk, mode), own in cells.items():
        if mode != 'auto':
            continue
        for what, error, sd, low, high in (
            ('parameters', 'error', 'sd', LOW, HIGH),
            ('end state', 'end_error', 'end_sd', END_LOW, END_HIGH),
        ):
            ends = [_interval(own, error, sd, i) for i in range(getattr(own[0], error).size)]
            yield Requirement(
                f'{name}, walk {walk:g}: coverage of {what} meets {low:g}-{high:g}',
                ', '.join(f'{first:.3f}-{last:.3f}' for first, last in ends),
                all(first <= high and last >= low for first, last in ends),
            )


def _share(own: Sequence[Solved], error: str, sd: str) -> list[float]:
    errors, deviations = _stacked(own, error, sd)
    given = np.isfinite(deviations)
    return (covered(errors, deviations).sum(axis=0) / np.maximum(given.sum(axis=0), 1)).tolist()


def _interval(own: Sequence[Solved], error: str, sd: str, i: int) -> tuple[float, float]:
    """Return the 95 % interval (Clopper & Pearson 1934) of one value's coverage."""
    errors, deviations = _stacked(own, error, sd)
    n = int(np.isfinite(deviations[:, i]).sum())
    hits = int(covered(errors[:, i], deviations[:, i]).sum())
    low = beta.ppf(0.025, hits, n - hits + 1) if hits else 0.0
    high = beta.ppf(0.975, hits + 1, n - hits) if hits < n else 1.0
    return float(low), float(high)


def _stacked(own: Sequence[Solved], error: str, sd: str) -> tuple[np.ndarray, np.ndarray]:
    return (
        np.array([getattr(one, error) for one in own]),
        np.array([getattr(one, sd) for one in own]),
    )
