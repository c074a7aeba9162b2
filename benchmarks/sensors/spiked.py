"""Recordings spiked by hand: what they forecast beside what the same ones forecast clean."""

import functools
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from benchmarks.recordings import OVERLAP, PLANTS, forecast, part, recorded, starts
from benchmarks.report import Requirement, table
from benchmarks.sensors.attempts import carried_out, failures, judged
from benchmarks.sensors.scores import Figure, resampled, words
from obs_ros import Estimate, Record, solve_window
from obs_ros.core.deadline import Deadline
from obs_ros.core.rng import random_generator
from obs_ros.core.typing import Array
from obs_ros.horizon.moving_horizon import MovingHorizon
from obs_ros.horizon.settings import EstimationSettings
from obs_ros.horizon.solver import Solver

SPIKED = ('heater board', 'car')
KINDS = ('clean', 'spiked')
WAYS = ('alone', 'in sequence')
HORIZONS = {'an eighth': 1.0 / 8.0, 'a window': 1.0}  # of a window
SHARE, SIZES = 0.01, (5.0, 30.0)  # of the samples; standard deviations of the noise
DRAWS = 4  # of the spikes: a window that determines little may be moved by any of them
WORSE = 1.05  # times the clean windows' forecast


class Forecasts(NamedTuple):
    """Mean squares (r,) of a window's forecasts by horizon, NaN beyond the recording; outcome."""

    squares: Mapping[str, Array]
    outcome: str


@functools.cache
def record(name: str, folder: Path, kind: str, draw: int = 0) -> Record:
    """Return a recording as it is, or with 1 % of its values, drawn anew, off by 5-30 deviations.

    The noise is what the second differences of neighbouring samples tell (median of their sizes),
    or the step of the sensor where most are equal.
    """
    whole = recorded(name, folder)
    if kind == 'clean':
        return whole
    rng, y = np.random.default_rng([len(name), draw]), whole.y.copy()
    sizes = rng.uniform(*SIZES, size=y.shape) * rng.choice((-1.0, 1.0), size=y.shape)
    return whole.with_outputs(y + sizes * noise(y) * (rng.random(y.shape) < SHARE))


def noise(y: Array) -> Array:
    """Return the standard deviations (r,) of noise in y (K, r)."""
    second = np.abs(np.diff(y, n=2, axis=0))
    steps = np.array([np.min(column[column > 1e-9 * np.ptp(column)]) for column in second.T])
    # Of normal second differences: variance 6, median of the size .6745 deviations.
    return np.asarray(np.maximum(np.median(second, axis=0) / (0.6745 * np.sqrt(6.0)), 0.3 * steps))


def windows(
    name: str, folder: str, kind: str, way: str, draw: int, most: int | None = None
) -> list[Forecasts]:
    """Solve windows of a recording, all or so many; forecasts are held against the clean one."""
    plant = PLANTS[name]
    clean, whole = record(name, Path(folder), 'clean'), record(name, Path(folder), kind, draw)
    horizon = MovingHorizon(Solver.of(plant.model, EstimationSettings()))
    found = []
    for i, start in enumerate(starts(plant, clean)[:most]):
        window = part(whole, start, start + plant.window)
        if way == 'alone':
            estimate = solve_window(plant.model, window, seed=1)
        else:
            estimate = horizon.solve(window, random_generator(1, i), Deadline())
        found.append(_forecasts(name, clean, estimate))
    return found


def _forecasts(name: str, clean: Record, found: Estimate) -> Forecasts:
    plant, squares = PLANTS[name], {}
    end = found.t1  # of the last output that was used: one left out tells no state
    for horizon, share in HORIZONS.items():
        ahead = part(clean, end, end + share * plant.window, closed=True)
        complete = ahead.t[-1] > end + 0.9 * share * plant.window
        off = forecast(plant.model, found, ahead)[1:] - ahead.y[1:]
        mean = np.mean(off**2, axis=0)
        squares[horizon] = mean if complete else np.full(mean.size, np.nan)
    return Forecasts(squares, found.outcome.value)


def measured(folder: Path, most: int | None = None) -> tuple[list[Requirement], str]:
    """Solve the recordings that are there, clean and spiked; return rows and table.

    Of each, so many windows at `most`.
    """
    there = [name for name in SPIKED if (folder / PLANTS[name].file).is_file()]
    cells = carried_out(
        windows, {(name, kind, way): [(name, str(folder), kind, way, draw, most)
                                      for draw in range(DRAWS if kind == 'spiked' else 1)]
                  for name in there for kind in KINDS for way in WAYS}, 'recordings',
    )  # fmt: skip
    return list(_rows(cells, there)), _table(cells)


def mean_squares(draws: list[list[Forecasts]], horizon: str) -> Array:
    """Return the mean squares (n, r) of each window's forecasts over the draws of spikes."""
    return np.mean([[one.squares[horizon] for one in own] for own in draws], axis=0)


def error_ratio(
    spiked: list[list[Forecasts]], clean: list[list[Forecasts]], horizon: str
) -> Figure:
    """Return the geometric mean over outputs of the ratios of RMS errors.

    The interval draws stretches of a window's length anew, as windows overlap.
    """
    both = np.array([mean_squares(draws, horizon) for draws in (spiked, clean)])
    whole = both[:, np.isfinite(both).all(axis=(0, 2))]

    def ratio(stretches: Array) -> float:
        places = (OVERLAP * stretches[:, None] + np.arange(OVERLAP)).ravel()
        bad, good = whole[:, places[places < whole.shape[1]]].mean(axis=1)
        return float(np.exp(0.5 * np.mean(np.log(bad / good))))

    return resampled(ratio, -(-whole.shape[1] // OVERLAP))


def _rows(
    cells: Mapping[tuple[str, str, str], list[Any]], names: list[str]
) -> Iterator[Requirement]:
    for name in names:
        for way in WAYS:
            clean, spiked = (cells[name, kind, way] for kind in KINDS)
            for horizon in HORIZONS:

                def near(both: list[Any], horizon: str = horizon) -> tuple[str, bool]:
                    found = error_ratio(both[1:], both[:1], horizon)
                    return words(found), found[0] <= WORSE

                asked = f'{name}, spiked, {way}: forecast over {horizon} <= {WORSE:g} x clean'
                yield judged(asked, [*clean, *spiked], near)


def _table(cells: Mapping[tuple[str, str, str], list[Any]]) -> str:
    rows = []
    for (name, kind, way), runs in cells.items():
        if not failures(runs):
            outcomes = [one.outcome for own in runs for one in own]
            rows.append({
                'recording': name, 'samples': kind, 'windows': f'{len(outcomes)} {way}',
                'outcomes': ', '.join(f'{n} {outcomes.count(n)}' for n in sorted({*outcomes})),
                **{
                    f'RMS over {horizon}': ' / '.join(
                        f'{e:.3g}'
                        for e in np.sqrt(np.nanmean(mean_squares(runs, horizon), axis=0))
                    )
                    for horizon in HORIZONS
                },
            })  # fmt: skip
    return table(rows)
