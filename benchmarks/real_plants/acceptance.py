"""What is asked of windows of recorded plants."""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from benchmarks.real_plants.run import HORIZONS, SOON, Solved
from benchmarks.real_plants.scores import (
    checked,
    factors,
    forecast_error,
    good_share,
    near_share,
    scatter_over_sd,
    together,
)
from benchmarks.recordings import PLANTS
from benchmarks.report import Requirement
from obs_ros.core.typing import Array

GOOD = 0.8  # of the windows
BALL = 'ball and beam'
BALL_SCATTER, BALL_FORECAST = 1.5, 9e-3  # of a, before the check; m, 1 s ahead
SCATTER = {'heater board': 2.5, 'battery': 2.5, 'car': 10.0}  # alone, before the check
LEAST_AFTER, MOST_AFTER = 0.5, {'heater board': 2.0, 'battery': 2.0, 'car': 3.0}
HOLDS = 2.0  # times: the factor of the first half on the second
NEAR, NEAR_SHARE = 3.0, 0.95  # deviations, and the share of values so near
WORSE = 1.05  # times the better forecast

# By plant, mode, and whether the windows are 'alone' or 'in sequence'.
Cells = Mapping[tuple[str, str, str], Sequence[Solved]]


def acceptance(cells: Cells) -> Iterator[Requirement]:
    """Yield what is asked of `auto`, for each recording that is there."""
    for name in dict.fromkeys(name for name, *_ in cells):
        alone, sequence = cells[name, 'auto', 'alone'], cells[name, 'auto', 'in sequence']
        for way, own in (('alone', alone), ('in sequence', sequence)):
            share = good_share(own)
            asked = f'{name}, {way}: >= {GOOD:.0%} converged or approximate, with deviations'
            yield Requirement(asked, f'{share:.0%}', share >= GOOD)
        if name == BALL:
            yield from _ball(alone)
        else:
            yield from _others(name, cells)


def _ball(alone: Sequence[Solved]) -> Iterator[Requirement]:
    scatter = scatter_over_sd(alone)[:1]
    yield _within(BALL, f'alone: scatter / sd <= {BALL_SCATTER:g}', scatter, 0.0, BALL_SCATTER)
    for words, errors in (
        (f'{SOON:g} s ahead', [one.soon[0] for one in alone]),
        (f'over {SOON:g} s', [one.till_soon[0] for one in alone]),
    ):
        error = float(np.sqrt(np.nanmean(np.square(errors))))
        asked = f'{BALL}, alone: forecast {words} <= {1e3 * BALL_FORECAST:g} mm (RMS)'
        yield Requirement(asked, f'{1e3 * error:.1f} mm', error <= BALL_FORECAST)


def _others(name: str, cells: Cells) -> Iterator[Requirement]:
    alone, sequence = cells[name, 'auto', 'alone'], cells[name, 'auto', 'in sequence']
    most, after = SCATTER[name], MOST_AFTER[name]
    yield _within(name, f'alone: scatter / sd <= {most:g}', scatter_over_sd(alone), 0.0, most)
    asked = f'in sequence, checked: scatter / sd {LEAST_AFTER:g}-{after:g}'
    yield _within(name, asked, scatter_over_sd(checked(sequence)), LEAST_AFTER, after)
    shown, needed = factors(sequence, alone)
    asked = f'factor on deviations, second half / first: within {HOLDS:g} times'
    yield _within(name, asked, needed / shown, 1.0 / HOLDS, HOLDS)
    for sds, larger in (('published sd', False), ('of the larger sd', True)):
        share = near_share(sequence, alone, NEAR, larger=larger)
        within = f'within {NEAR:g} {sds} of the value alone'
        yield Requirement(
            f'{name}, in sequence: >= {NEAR_SHARE:.0%} of values {within}',
            f'{share:.0%}' if np.isfinite(share) else '-',
            share >= NEAR_SHARE,
        )
    for horizon in HORIZONS:
        better = min(
            together(forecast_error(cells[name, mode, 'alone'], horizon))
            for mode in ('off', 'auto')
        )
        ratio = together(forecast_error(sequence, horizon)) / better
        asked = f'{name}, in sequence: forecast over {horizon} <= {WORSE:g} x the better fit'
        yield Requirement(asked, f'{ratio:.3f}', bool(ratio <= WORSE))


def _within(name: str, asked: str, values: Array, low: float, high: float) -> Requirement:
    """Return the requirement on every parameter's value; one that is missing does not meet it."""
    variables = PLANTS[name].model.parameters
    told = [
        f'{variable.name} {value:.2f}' if np.isfinite(value) else f'{variable.name} -'
        for variable, value in zip(variables, values, strict=False)
    ]
    met = values.size > 0 and bool(((values >= low) & (values <= high)).all())
    return Requirement(f'{name}, {asked}', ', '.join(told) or '-', met)
