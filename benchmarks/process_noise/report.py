"""Tables of windows with process noise: coverage, errors, outcomes, time, and what is asked."""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from benchmarks.intervals import covered, share_interval
from benchmarks.process_noise.plants import PLANTS
from benchmarks.process_noise.run import MODES, Solved, Window
from benchmarks.report import Requirement, rms, slashed, table
from obs_ros.core.typing import Array

LOW, HIGH = 0.93, 0.97  # of intervals of 95 %
END_LOW, END_HIGH = 0.90, 0.98  # of those of end states
MEAN_LOW, MEAN_HIGH = 0.935, 0.965  # of all cells together
WALK_OFF = 0.15  # of the true walk, in the median
ERRORS = 1.1  # times those of the reference
DRAWS = 1000  # of the bootstrap
TIMES = {'exact': 1.3, 'pushed': 3.0, 'warm': 2.0}  # times that of the mode off

Cells = Mapping[tuple[str, float], Sequence[Window]]


def results(cells: Cells) -> str:
    """Tell coverage, errors and outcomes of each cell."""
    rows = []
    for (name, walk), windows in cells.items():
        for mode in MODES:
            own = of_mode(windows, mode)
            outcomes = Counter(one.outcome for one in own)
            rows.append(
                {
                    'plant': name,
                    'walk': f'{walk:g}',
                    'process_noise': mode,
                    'coverage of parameters': slashed(_share(own, 'error', 'sd')),
                    'of the end state': slashed(_share(own, 'end_error', 'end_sd')),
                    'RMS error': slashed(rms(_stacked(own, 'error'), axis=0), '.4g'),
                    'walks, median': slashed(np.median(_stacked(own, 'walks'), axis=0), '.3g'),
                    'withheld': f'{np.mean([np.isnan(one.sd).any() for one in own]):.2f}',
                    'outcomes': ', '.join(f'{key} {n}' for key, n in outcomes.most_common()),
                    'ms': f'{1e3 * np.median([one.seconds for one in own]):.0f}',
                    'warm': f'{1e3 * np.nanmedian([window.warm[mode] for window in windows]):.0f}',
                }
            )
    return table(rows)


def acceptance(cells: Cells) -> Iterator[Requirement]:
    """Yield what is asked of `auto`, cell by cell, and of all cells together."""
    shares: list[float] = []
    for (name, walk), windows in cells.items():
        own, cell = of_mode(windows, 'auto'), f'{name}, walk {walk:g}'
        for what, error, sd, low, high in (
            ('parameters', 'error', 'sd', LOW, HIGH),
            ('end state', 'end_error', 'end_sd', END_LOW, END_HIGH),
        ):
            shares += _share(own, error, sd)
            ends = [_interval(own, error, sd, i) for i in range(getattr(own[0], error).size)]
            yield Requirement(
                f'{cell}: coverage of {what} meets {low:g}-{high:g}',
                ', '.join(f'{first:.3f}-{last:.3f}' for first, last in ends),
                all(first <= high and last >= low for first, last in ends),
            )
        if walk > 0.0:
            yield _walks(cell, walk, own)
        seconds = {mode: [one.seconds for one in of_mode(windows, mode)] for mode in MODES}
        yield _time_ratio(f'{cell}: cold', 'pushed' if walk > 0.0 else 'exact', seconds)
        referred = [window for window in windows if np.isfinite(window.reference).all()]
        if referred:
            warm = {mode: [window.warm[mode] for window in referred] for mode in MODES}
            yield _time_ratio(f'{cell}: warm', 'warm', warm)
            yield _errors(cell, name, referred)
    mean = float(np.mean(shares))
    yield Requirement(
        f'mean coverage of all cells within {MEAN_LOW:g}-{MEAN_HIGH:g}',
        f'{mean:.3f}',
        MEAN_LOW <= mean <= MEAN_HIGH,
    )


def of_mode(windows: Sequence[Window], mode: str) -> list[Solved]:
    """Return how each window was solved in a mode."""
    return [window.modes[mode] for window in windows]


def error_ratios(windows: Sequence[Window], seed: int = 0) -> tuple[Array, Array]:
    """Return RMS errors of `auto` over the reference's (q,), and 95 % intervals (2, q) of them.

    Windows are drawn with replacement (percentile bootstrap).
    """
    pairs = np.array([(window.modes['auto'].error, window.reference) for window in windows])
    pairs = pairs[np.isfinite(pairs).all(axis=(1, 2))] ** 2
    drawn = np.random.default_rng(seed).integers(len(pairs), size=(DRAWS, len(pairs)))
    ours, theirs = np.moveaxis(pairs[drawn].mean(axis=1), 1, 0)
    found = np.sqrt(pairs[:, 0].mean(axis=0) / pairs[:, 1].mean(axis=0))
    return found, np.quantile(np.sqrt(ours / theirs), (0.025, 0.975), axis=0)


def _walks(cell: str, walk: float, own: Sequence[Solved]) -> Requirement:
    off = np.median(_stacked(own, 'walks'), axis=0) / walk - 1.0
    return Requirement(
        f'{cell}: walks within {WALK_OFF:.0%} in the median',
        ', '.join(f'{each:+.1%}' for each in off),
        bool((np.abs(off) <= WALK_OFF).all()),
    )


def _time_ratio(cell: str, kind: str, seconds: Mapping[str, Sequence[float]]) -> Requirement:
    ratio = float(np.median(seconds['auto']) / np.median(seconds['off']))
    asked = f'{cell} time <= {TIMES[kind]:g} x that of `off`, medians'
    return Requirement(asked, f'{ratio:.2f}', ratio <= TIMES[kind])


def _errors(cell: str, name: str, windows: Sequence[Window]) -> Requirement:
    found, (low, high) = error_ratios(windows)
    names = [PLANTS[name].model.parameters[i].name for i in PLANTS[name].estimated]
    rows = zip(names, found, low, high, strict=True)
    return Requirement(
        f"{cell}: RMS errors <= {ERRORS:g} x the reference's",
        ', '.join(f'{each} {ratio:.2f} ({a:.2f}-{b:.2f})' for each, ratio, a, b in rows),
        bool((low <= ERRORS).all()),
    )


def _share(own: Sequence[Solved], error: str, sd: str) -> list[float]:
    errors, deviations = _stacked(own, error), _stacked(own, sd)
    given = np.isfinite(deviations)
    return (covered(errors, deviations).sum(axis=0) / np.maximum(given.sum(axis=0), 1)).tolist()


def _interval(own: Sequence[Solved], error: str, sd: str, i: int) -> tuple[float, float]:
    errors, deviations = _stacked(own, error)[:, i], _stacked(own, sd)[:, i]
    hits, count = covered(errors, deviations).sum(), np.isfinite(deviations).sum()
    return share_interval(int(hits), int(count))


def _stacked(own: Sequence[Solved], field: str) -> Array:
    return np.array([getattr(one, field) for one in own])
