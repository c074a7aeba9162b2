"""Tables of recorded plants: outcomes, how disjoint windows scatter, forecasts."""

from collections import Counter

import numpy as np

from benchmarks.real_plants.acceptance import Cells
from benchmarks.real_plants.run import HORIZONS
from benchmarks.real_plants.scores import forecast_error, good_share, near_share, scatter_over_sd
from benchmarks.recordings import PLANTS
from benchmarks.report import slashed, table


def outcomes_table(cells: Cells) -> str:
    """Tell outcomes and the share of windows with every deviation."""
    rows = []
    for (name, mode, way), own in cells.items():
        counts = Counter(one.outcome for one in own)
        rows.append(
            {
                'plant': name,
                'process_noise': mode,
                'windows': f'{len(own)} {way}',
                'outcomes': ', '.join(f'{key} {count}' for key, count in counts.most_common()),
                'all deviations given': f'{np.mean([np.isfinite(o.sd).all() for o in own]):.2f}',
                'good, with all': f'{good_share(own):.2f}',
                'ms': f'{1e3 * np.median([one.seconds for one in own]):.0f}',
            }
        )
    return table(rows)


def scatter_table(cells: Cells) -> str:
    """Tell the scatter of disjoint windows over the deviations that they publish."""
    rows = []
    for (name, mode, way), own in cells.items():
        scatter = scatter_over_sd(own)
        for i, variable in enumerate(PLANTS[name].model.parameters):
            sd = np.array([one.sd[i] for one in own])
            given = np.isfinite(sd)
            rows.append(
                {
                    'plant': name,
                    'process_noise': mode,
                    'windows': way,
                    'parameter': variable.name,
                    'median': f'{np.median([one.values[i] for one in own]):.4g}',
                    'median sd': f'{np.median(sd[given]):.2g}' if given.any() else '-',
                    'scatter / sd': _number(scatter[i]),
                    'its own figure': _number(own[-1].factor[i]),
                    'windows with sd': f'{given.sum()} of {len(own)}',
                }
            )
    return table(rows)


def nearness_table(cells: Cells) -> str:
    """Tell how often windows in sequence keep to the same windows alone."""
    rows = []
    for name, mode, way in cells:
        if way == 'in sequence':
            pair = cells[name, mode, way], cells[name, mode, 'alone']
            shares = {
                f'within {sds} {words}': _number(near_share(*pair, sds, larger=larger))
                for words, larger in (('sd', False), ('of the larger sd', True))
                for sds in (1, 2, 3)
            }
            rows.append({'plant': name, 'process_noise': mode, **shares})
    return table(rows)


def forecasts_table(cells: Cells) -> str:
    """Tell root mean square errors of forecasts, beside those of the last value held."""
    rows = []
    for name in dict.fromkeys(name for name, *_ in cells):
        own = {(mode, way): each for (other, mode, way), each in cells.items() if other == name}
        for horizon in HORIZONS:
            held = forecast_error(next(iter(own.values())), horizon, held=True)
            row = {'plant': name, 'over': horizon, 'hold': slashed(held, '.3g')}
            for (mode, way), each in own.items():
                row[f'{mode}, {way}'] = slashed(forecast_error(each, horizon), '.3g')
            rows.append(row)
    return table(rows)


def _number(value: float) -> str:
    return f'{value:.2f}' if np.isfinite(value) else '-'
