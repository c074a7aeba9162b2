"""Tables of recorded plants: outcomes, how disjoint windows scatter, forecasts."""

from collections import Counter
from collections.abc import Mapping, Sequence

import numpy as np

from benchmarks.real_plants.plants import PLANTS
from benchmarks.real_plants.run import HORIZONS, OVERLAP, Solved
from benchmarks.report import slashed, table

Cells = Mapping[tuple[str, str], Sequence[Solved]]


def outcomes_table(cells: Cells) -> str:
    """Tell outcomes and the share of windows with every deviation."""
    rows = []
    for (name, mode), own in cells.items():
        counts = Counter(one.outcome for one in own)
        rows.append(
            {
                'plant': name,
                'process_noise': mode,
                'windows': len(own),
                'outcomes': ', '.join(f'{key} {count}' for key, count in counts.most_common()),
                'all deviations given': f'{np.mean([np.isfinite(o.sd).all() for o in own]):.2f}',
                'ms': f'{1e3 * np.median([one.seconds for one in own]):.0f}',
            }
        )
    return table(rows)


def scatter_table(cells: Cells) -> str:
    """Tell the scatter of disjoint windows over the deviations that they publish."""
    rows = []
    for (name, mode), own in cells.items():
        for i, variable in enumerate(PLANTS[name].model.parameters):
            values = np.array([one.values[i] for one in own])
            sd = np.array([one.sd[i] for one in own])
            given = np.isfinite(sd)
            rows.append(
                {
                    'plant': name,
                    'process_noise': mode,
                    'parameter': variable.name,
                    'median': f'{np.median(values):.4g}',
                    'median sd': f'{np.median(sd[given]):.2g}' if given.any() else '-',
                    'scatter / sd': _scatter_over_sd(values, sd),
                    'windows with sd': f'{given.sum()} of {len(own)}',
                }
            )
    return table(rows)


def _scatter_over_sd(values: np.ndarray, sd: np.ndarray) -> str:
    """Return the median over the interleaved rows of disjoint windows; - with fewer than three."""
    ratios = []
    for first in range(OVERLAP):
        v, s = values[first::OVERLAP], sd[first::OVERLAP]
        given = np.isfinite(s)
        if given.sum() >= 3:
            weights = 1.0 / s[given] ** 2
            mean = np.average(v[given], weights=weights)
            ratios.append(np.sqrt(np.sum(weights * (v[given] - mean) ** 2) / (given.sum() - 1)))
    return f'{np.median(ratios):.2f}' if ratios else '-'


def forecasts_table(cells: Cells) -> str:
    """Tell root mean square errors of forecasts, beside those of the last value held."""
    rows = []
    for name in dict.fromkeys(name for name, _ in cells):
        for horizon in HORIZONS:
            modes = {mode: own for (other, mode), own in cells.items() if other == name}
            row = {'plant': name, 'over': horizon}
            some = next(iter(modes.values()))
            row['hold'] = _pooled([one.hold[horizon] for one in some])
            for mode, own in modes.items():
                row[mode] = _pooled([one.forecast[horizon] for one in own])
            rows.append(row)
    return table(rows)


def _pooled(errors: Sequence[np.ndarray]) -> str:
    return slashed(np.sqrt(np.nanmean(np.square(errors), axis=0)), '.3g')
