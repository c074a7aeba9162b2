"""Outliers on a spring: spikes, bursts, dropouts; errors, outcomes and coverage beside clean data.

And clean data: the efficiency of the robust loss beside squares, its cost beside those and beside
another source tree. Filters meet the same outliers.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.play import followed
from benchmarks.report import Requirement, table
from benchmarks.sensors import clean_cost
from benchmarks.sensors.attempts import attempted, carried_out, failures, judged
from benchmarks.sensors.scores import (
    accepted,
    coverage,
    efficiency,
    median_ratio,
    resampled,
    rms_ratio,
    words,
    worst_ratio,
)
from benchmarks.sensors.solved import Solved, alone, in_sequence
from benchmarks.sensors.spikes import BY_RATE, CLEAN, FAULTS, IN_RUN, spoiled
from benchmarks.sensors.spring import NOISE, SAMPLES, SPRING, run
from obs_ros import Sample
from obs_ros.core.typing import Array
from obs_ros.observers.base import load_observer

WAYS = ('given, alone', 'given, in sequence', 'learned, alone', 'learned, in sequence')  # noise
WORST, LEAST_ACCEPTED, RMS, COVERED = 1.3, 0.9, 1.15, (0.92, 0.97)
EFFICIENT, COST = 0.95, 1.1
FILTERS = ('ekf', 'ukf')


def windows(kind: str, way: str, seed: int) -> list[Solved]:
    """Solve the windows of a run, alone or in sequence, the noise given or learned."""
    drawn = spoiled(kind, seed)
    noise = {'noise': {'y': NOISE}} if way.startswith('given') else {}
    if way.endswith('sequence'):
        return in_sequence(SPRING, drawn.windows(), drawn.truth, seed, **noise)
    return [alone(SPRING, window, drawn.truth, seed, **noise) for window in drawn.windows()]


def by_loss(loss: str, seed: int) -> list[Solved]:
    """Solve the clean windows of a run alone with a loss, the noise given."""
    drawn = run(seed, SAMPLES * IN_RUN)
    known: dict[str, Any] = {'noise': {'y': NOISE}, 'loss': loss}
    return [alone(SPRING, window, drawn.truth, seed, **known) for window in drawn.windows()]


def filtered(kind: str, name: str, seed: int) -> Array:
    """Return the errors (K,) of a filter's positions in the second half of a run."""
    drawn = spoiled(kind, seed)
    observer: Any = load_observer(name)
    record = drawn.record
    samples = [
        Sample(round(t * 1e9), y=y, u=u)
        for t, u, y in zip(record.t, record.u, record.y, strict=True)
    ]
    estimates, _ = followed(observer(SPRING, noise={'y': NOISE}), samples)
    positions = np.array([one.state['position'] for one in estimates])
    return np.asarray(positions - drawn.x[:, 0])[SAMPLES * IN_RUN // 2 :]


def measured(runs: int, seed: int, other: Path | None) -> tuple[list[Requirement], str]:
    """Solve so many runs of each kind; return the rows asked and the table of all cells."""
    attempted(windows, CLEAN, WAYS[0], seed)  # compiles here, so that workers find it cached
    seeds = range(seed, seed + runs)
    cells = carried_out(
        windows,
        {(kind, way): [(kind, way, each) for each in seeds] for kind in (CLEAN, *FAULTS)
         for way in WAYS}, 'outliers',
    )  # fmt: skip
    losses = carried_out(
        by_loss,
        {loss: [(loss, each) for each in seeds] for loss in ('robust', 'squares')},
        'losses',
    )
    kinds = (CLEAN, BY_RATE[0])
    filters = carried_out(
        filtered, {(kind, name): [(kind, name, each) for each in seeds] for kind in kinds
                   for name in FILTERS}, 'filters',
    )  # fmt: skip
    times = {
        '`loss: squares`': [
            attempted(clean_cost.paired, {}, {'loss': 'squares'}, each) for each in seeds
        ],
        **({'the other tree': clean_cost.against(other, seeds)} if other else {}),
    }
    rows = [*_faults(cells), *_rates(cells), *_clean(losses, times), *_filters(filters)]
    return rows, _table(cells)


def _faults(cells: Mapping[tuple[str, str], list[Any]]) -> Iterator[Requirement]:
    for kind in FAULTS:
        if kind in BY_RATE:
            continue
        yield _over_ways(
            cells, kind, f'{kind}: >= {LEAST_ACCEPTED:.0%} of windows accepted',
            lambda bad, good: accepted(bad)[0], '.0%', lambda figure: figure >= LEAST_ACCEPTED,
        )  # fmt: skip
        yield _over_ways(
            cells, kind, f'{kind}: worst error of a parameter <= {WORST:g} x that of clean data',
            worst_ratio, '.2f', lambda figure: figure <= WORST,
        )  # fmt: skip
        yield _over_ways(
            cells, kind, f'{kind}: no jump',
            lambda bad, good: sum(one.jumps for one in bad), '.0f', lambda figure: figure == 0,
        )  # fmt: skip


def _over_ways(
    cells: Mapping[tuple[str, str], list[Any]],
    kind: str,
    asked: str,
    figure: Callable[[list[Solved], list[Solved]], float],
    form: str,
    met: Callable[[float], bool],
) -> Requirement:
    """Return the row of a figure that every way of solving has to meet."""
    everything = [one for way in WAYS for each in (kind, CLEAN) for one in cells[each, way]]

    def judge(_: list[Any]) -> tuple[str, bool]:
        figures = {way: figure(flat(cells[kind, way]), flat(cells[CLEAN, way])) for way in WAYS}
        said = '; '.join(f'{way} {format(value, form)}' for way, value in figures.items())
        return said, all(met(value) for value in figures.values())

    return judged(asked, everything, judge)


def _rates(cells: Mapping[tuple[str, str], list[Any]]) -> Iterator[Requirement]:
    for kind in BY_RATE:
        for way in WAYS:
            bad, good = cells[kind, way], cells[CLEAN, way]

            def ratio(_: list[Any], bad: Any = bad, good: Any = good) -> tuple[str, bool]:
                found = rms_ratio(flat(bad), flat(good))
                return words(found), found[0] <= RMS

            yield judged(f'{kind}, {way}: RMS error <= {RMS:g} x clean', [*bad, *good], ratio)
            asked = f'{kind}, {way}: coverage {COVERED[0]:g}-{COVERED[1]:g}'
            yield judged(asked, bad, covers)


def covers(runs: list[Any]) -> tuple[str, bool]:
    """Judge the coverage of the windows of runs."""
    found = coverage(flat(runs))
    return words(found), COVERED[0] <= found[0] <= COVERED[1]


def _clean(
    losses: Mapping[str, list[Any]], times: Mapping[str, list[Any]]
) -> Iterator[Requirement]:
    def efficient(_: list[Any]) -> tuple[str, bool]:
        found = efficiency(flat(losses['robust']), flat(losses['squares']))
        return words(found), found[0] >= EFFICIENT

    both = [*losses['robust'], *losses['squares']]
    yield judged(f'clean: efficiency >= {EFFICIENT:.0%} beside squares', both, efficient)
    for words_of_it, pairs in times.items():

        def cheap(pairs: list[Any]) -> tuple[str, bool]:
            found = median_ratio(*zip(*pairs, strict=True))
            return words(found), found[0] <= COST

        yield judged(f'clean: time <= {COST:g} x that of {words_of_it}', pairs, cheap)


def _filters(cells: Mapping[tuple[str, str], list[Any]]) -> Iterator[Requirement]:
    for name in FILTERS:
        bad, good = cells[BY_RATE[0], name], cells[CLEAN, name]

        def ratio(_: list[Any], bad: Any = bad, good: Any = good) -> tuple[str, bool]:
            squares = np.array([[np.mean(e**2) for e in own] for own in (bad, good)])
            found = resampled(
                lambda places: float(np.sqrt(np.divide(*squares[:, places].mean(axis=1)))),
                squares.shape[1],
            )
            return words(found), found[0] <= RMS

        asked = f'{name}, {BY_RATE[0]}: RMS error of the position <= {RMS:g} x clean'
        yield judged(asked, [*bad, *good], ratio)


def flat(runs: Sequence[list[Solved]]) -> list[Solved]:
    """Return the windows of all runs."""
    return [window for own in runs for window in own]


def _table(cells: Mapping[tuple[str, str], list[Any]]) -> str:
    rows = []
    for (kind, way), runs in cells.items():
        clean = cells[CLEAN, way]
        if failures([*runs, *clean]):
            continue
        bad, good = flat(runs), flat(clean)
        rows.append({
            'fault': kind, 'noise, windows': way, 'windows': len(bad),
            'accepted': words(accepted(bad), '.2f'),
            'worst / clean': f'{worst_ratio(bad, good):.2f}',
            'RMS / clean': words(rms_ratio(bad, good)), 'coverage': words(coverage(bad)),
            'jumps': sum(one.jumps for one in bad),
            'ms': f'{1e3 * np.median([one.seconds for one in bad]):.1f}',
        })  # fmt: skip
    return table(rows)
