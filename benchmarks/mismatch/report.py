"""Tables of windows that their model does not fit: what sequences publish, and what they cost."""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from benchmarks.intervals import share_interval
from benchmarks.mismatch.cost import FITS, Cost
from benchmarks.mismatch.run import Followed
from benchmarks.mismatch.scores import CYCLES, LAG, SDS, cycles, frozen, nearness
from benchmarks.report import Requirement, table

NEAR = 0.95  # of the values
CYCLING = 0.05  # of the parameters' sequences: chance alone
MOST = 5.0  # times the candidate-steps of a window that fits

Sequences = Mapping[tuple[str, str, str], Sequence[Followed]]  # by scene, spacing and mode
Costs = Mapping[tuple[str, str, str], Sequence[Cost]]  # by case, kind and knowledge of the noise


def sequences_table(cells: Sequences) -> str:
    """Tell outcomes, and how published values follow those of the windows alone."""
    rows = []
    for (scene, spacing, mode), runs in cells.items():
        rows.append({
            'model': scene,
            'windows every': spacing,
            'process_noise': mode,
            'outcomes': _outcomes(run.outcomes for run in runs),
            'alone': _outcomes(run.alone_outcomes for run in runs),
            'determined by both': f'{_determined(runs):.2f}',
            f'within {SDS:g} published sd': _share(*nearness(runs)),
            f'within {SDS:g} of the larger sd': _share(*nearness(runs, larger=True)),
            'frozen': sum(frozen(run) for run in runs),
            'cycling': _share(*_cycling(runs)),
        })  # fmt: skip
    return table(rows)


def costs_table(costs: Costs) -> str:
    """Tell candidate-steps, in millions and in those of a window that fits, outcomes and time."""
    rows = []
    for (case, kind, known), own in costs.items():
        ratios = _ratios(costs, case, kind, known)
        rows.append({
            'model': case,
            'noise': known,
            'window': kind,
            'candidate-steps (10^6)': f'{1e-6 * np.median([one.steps for one in own]):.2f}',
            'ratio, median': f'{np.median(ratios):.2f}',
            'worst': f'{ratios.max():.2f}',
            'outcomes': _outcomes([[one.outcome for one in own]]),
            'ms': f'{1e3 * np.median([one.seconds for one in own]):.0f}',
        })  # fmt: skip
    return table(rows)


def acceptance(cells: Sequences, costs: Costs) -> Iterator[Requirement]:
    """Yield what is asked of the mode `auto` in sequence, and of all costs."""
    for (scene, spacing, mode), runs in cells.items():
        if mode == 'auto':
            yield from _followed(f'{scene}, every {spacing}', runs)
    for case, kind, known in costs:
        if kind != FITS:
            ratios = _ratios(costs, case, kind, known)
            yield Requirement(
                f'{case}, noise {known}, {kind}: <= {MOST:g} x the cost of one that fits',
                f'median {np.median(ratios):.2f}, worst {ratios.max():.2f}',
                bool(ratios.max() <= MOST),
            )


def _followed(every: str, runs: Sequence[Followed]) -> Iterator[Requirement]:
    for sds, larger in (('published sd', False), ('of the larger sd', True)):
        near, count = nearness(runs, larger=larger)
        asked = f'{every}: >= {NEAR:.0%} of values within {SDS:g} {sds} of the value alone'
        yield Requirement(asked, _share(near, count), bool(count and near >= NEAR * count))
    steps = sum(frozen(run) for run in runs)
    yield Requirement(f'{every}: no value is frozen', f'{steps} times', steps == 0)
    found, count = _cycling(runs)
    yield Requirement(
        f'{every}: correlation with {LAG} windows before > {CYCLES:g} in at most {CYCLING:.0%}',
        _share(found, count),
        share_interval(found, count)[0] <= CYCLING,
    )


def _determined(runs: Sequence[Followed]) -> float:
    return nearness(runs)[1] / sum(run.values.size for run in runs)


def _cycling(runs: Sequence[Followed]) -> tuple[int, int]:
    found = np.array([cycles(run) for run in runs])
    return int(found.sum()), found.size


def _ratios(costs: Costs, case: str, kind: str, known: str) -> np.ndarray:
    fits = np.median([one.steps for one in costs[case, FITS, known]])
    return np.array([one.steps for one in costs[case, kind, known]]) / fits


def _share(hits: int, count: int) -> str:
    if not count:
        return '-'
    low, high = share_interval(hits, count)
    return f'{hits / count:.3f} ({low:.3f}-{high:.3f})'


def _outcomes(runs: Iterator[list[str]] | Sequence[list[str]]) -> str:
    counts = Counter(outcome for outcomes in runs for outcome in outcomes)
    return ', '.join(f'{key} {count}' for key, count in counts.most_common())
