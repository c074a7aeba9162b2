"""Tables of the windows of Yang, Li & Dahhou 2020."""

from collections.abc import Mapping

import numpy as np

from benchmarks.papers.claims import share
from benchmarks.papers.yang.comparisons import as_good, ratio
from benchmarks.papers.yang.convergence import LAST_EVALUATIONS, Followed
from benchmarks.papers.yang.reference import printed_errors
from benchmarks.papers.yang.run import (
    DEFAULT,
    FOLLOWED,
    FOLLOWED_SNR,
    LONGER,
    PAPER,
    WAYS,
    Errors,
    Figures,
    bounds,
)
from benchmarks.papers.yang.sequence import COLD, LATER, scores
from benchmarks.papers.yang.sequence import WAYS as SEQUENCES
from benchmarks.papers.yang.starts import PAPER as PAPERS_SEARCH
from benchmarks.papers.yang.starts import UNIFORM, errors_from
from benchmarks.papers.yang.table_claims import fitness_ratio
from benchmarks.papers.yang.theorem import MOST_GENERATIONS, SHRUNK
from benchmarks.report import filled, rms, table
from benchmarks.tanks import PAPER_WINDOWS, noise_of

TITLES = {'ft1': '1 (f_t1, Euclidean)', 'ft2': '2 (f_t2, correlation)'}


def report(figures: Figures) -> str:
    """Return the tables of the report."""
    return filled(
        'papers/yang/report',
        tables='\n\n'.join(
            f'## Table {title}\n\n{paper_table(figures, fitness)}'
            for fitness, title in TITLES.items()
        ),
        fitness=fitness_table(figures),
        noise=noise_table(figures),
        starts=starts_table(figures),
        sequence=sequence_table(figures),
        theorem=theorem_table(figures),
        most=MOST_GENERATIONS,
        shrunk=SHRUNK,
        ways='; '.join(f'`{way}`: {WAYS[way]}' for way in (PAPER, LONGER, DEFAULT)),
        default=default_table(figures.errors),
        followed=min(FOLLOWED, figures.seeds),
        convergence=convergence_table(figures.followed),
        snr=FOLLOWED_SNR,
    )


def paper_table(figures: Figures, fitness: str) -> str:
    """Hold the printed runs beside ours: how many seeds are as good."""
    rows = []
    for cell in (cell for cell in figures.cells if cell.fitness == fitness):
        printed = printed_errors(cell)
        row = {
            'window': cell.window,
            'SNR (dB)': decibels(cell.snr_db),
            'printed errors': told(printed),
            'our median': told(np.median(figures.errors[cell, PAPER], axis=0)),
        }
        together, each = as_good(figures.errors, cell)
        known = not np.isnan(printed).any()
        row['seeds as good, all four errors'] = share(together, figures.seeds) if known else '-'
        row['each of p1 p2 p3 h3'] = ' '.join(map(str, each)) if known else '-'
        rows.append(row)
    return table(rows)


def fitness_table(figures: Figures) -> str:
    """Compare the fitness functions, with and without noise."""
    cells = [cell for cell in figures.cells if cell.fitness == 'ft1']
    rows = []
    for cell in cells:
        found = fitness_ratio(figures, cell)
        rows.append({
            'window': cell.window,
            'SNR (dB)': decibels(cell.snr_db),
            'errors, f_t1 / f_t2': found,
            'f_t1 has': f'{found.word}{" errors" if found.worse or found.better else ""}',
        })  # fmt: skip
    return table(rows)


def noise_table(figures: Figures) -> str:
    """Tell the fitness at the end of the search and at the truth: Figures 12 and 13."""
    rows = []
    for cell in (cell for cell in figures.cells if cell.fitness == 'ft1'):
        distance = [one.distance for one in figures.solves[cell, PAPER]]
        other = figures.solves[cell._replace(fitness='ft2'), PAPER]
        correlation = [one.correlation for one in other]
        rows.append({
            'window': cell.window,
            'SNR (dB)': decibels(cell.snr_db),
            'distance (cm), found by f_t1 / truth': pair(distance, '.3g'),
            'sum of correlations, found by f_t2 / truth': pair(correlation, '.5f'),
        })  # fmt: skip
    return table(rows)


def pair(values: list[tuple[float, float]], form: str) -> str:
    """Return the medians of what was found and of the truth."""
    return ' / '.join(format(float(value), form) for value in np.median(values, axis=0))


def starts_table(figures: Figures) -> str:
    """Compare first populations with uniform ones."""
    rows = []
    for search, kind in dict.fromkeys((search, kind) for search, kind, _ in figures.starts):
        row: dict[str, object] = {'search': search, 'start': kind}
        for window in PAPER_WINDOWS:
            own = figures.starts[search, kind, window]
            evaluations = f'{np.median([one.evaluations for one in own]):.0f}'
            if search == PAPERS_SEARCH:
                pairs = (errors_from(figures.starts, search, k, window) for k in (kind, UNIFORM))
                row[window] = '1' if kind == UNIFORM else ratio(*pairs)
            else:
                counts = (
                    [float(one.evaluations) for one in figures.starts[search, k, window]]
                    for k in (kind, UNIFORM)
                )
                row[window] = f'{evaluations}: {1 if kind == UNIFORM else ratio(*counts)}'
        rows.append(row)
    return table(rows)


def sequence_table(figures: Figures) -> str:
    """Compare ways from window to window with cold starts."""
    rows = []
    for way in SEQUENCES:
        row: dict[str, object] = {'later windows': way}
        for name in LATER:
            own, cold = (scores(figures.sequences, w, name) for w in (way, COLD))
            row[name] = '1' if way == COLD else ratio(own, cold)
        rows.append(row)
    return table(rows)


def theorem_table(figures: Figures) -> str:
    """Tell where the populations ended on Lorenz's plant."""
    return table(
        {
            'start': kind,
            'runs': len(runs),
            'truth found': share(sum(run.found for run in runs), len(runs)),
            'shrunk away from it': share(sum(run.lost for run in runs), len(runs)),
            'generations, median': f'{np.median([run.generations for run in runs]):.0f}',
        }
        for kind, runs in figures.collapses.items()
    )


def default_table(errors: Errors) -> str:
    """Show the default search beside the Cramér-Rao bound."""
    rows = []
    for cell, way in errors:
        if way not in (PAPER, DEFAULT, LONGER) or cell.fitness != 'ft1' or np.isinf(cell.snr_db):
            continue
        bound = noise_of(cell.snr_db) * bounds(cell.window, 6 if way == DEFAULT else 4)
        ratios = rms(errors[cell, way], 0) / bound
        rows.append((cell, {
            'window': cell.window,
            'SNR (dB)': decibels(cell.snr_db),
            'search': way,
            'median error': told(np.median(errors[cell, way], axis=0)),
            'Cramér-Rao bound': told(bound),
            'RMSE / bound': ' '.join(f'{value:.2f}' for value in ratios),
        }))  # fmt: skip
    order = [cell for cell, way in errors if way == PAPER]
    return table(row for _, row in sorted(rows, key=lambda row: order.index(row[0])))


def convergence_table(followed: Mapping[tuple[str, str], Followed]) -> str:
    """Tell how far each search has come after some numbers of candidates."""
    counts = (200, 500, 1000, LAST_EVALUATIONS)
    rows = [
        {'window': window, 'search': method}
        | {
            f'{count} candidates': f'{excess:.2g}'
            for count, excess in zip(
                counts, np.interp(counts, run.evaluations, run.excess), strict=True
            )
        }
        for (window, method), run in followed.items()
    ]
    return table(rows)


def told(values: np.ndarray) -> str:
    """Return numbers with two significant digits; nothing for NaN."""
    return '-' if np.isnan(values).all() else ' '.join(f'{value:.1e}' for value in values)


def decibels(snr: float) -> str:
    """Return a signal-to-noise ratio as text."""
    return 'no noise' if np.isinf(snr) else f'{snr:g}'
