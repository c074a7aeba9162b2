"""Tables of the windows of Yang, Li & Dahhou 2020."""

from collections.abc import Mapping, Sequence

import numpy as np

from benchmarks.papers.yang.convergence import LAST_EVALUATIONS, Followed
from benchmarks.papers.yang.reference import Cell, references
from benchmarks.papers.yang.run import (
    DEFAULT,
    FIRST_SAMPLE,
    FOLLOWED_SNR,
    MEMETIC,
    PAPER,
    WAYS,
    Errors,
    Figures,
    bounds,
)
from benchmarks.report import Requirement, filled, requirements, rms, table
from benchmarks.tanks import noise_of
from obs_ros.core.typing import Array

TITLES = {'ft1': '1 (f_t1, euclidean)', 'ft2': '2 (f_t2, correlation)'}


def report(figures: Figures) -> str:
    """Return the tables of the report."""
    errors, cells = figures.errors, figures.cells
    one_fitness = [cell for cell in cells if cell.fitness == cells[0].fitness]
    noisy = [cell for cell in one_fitness if np.isfinite(cell.snr_db)]
    reading, distance = reading_table(errors, noisy)
    told = (f'`{way}`: {meaning}' for way, meaning in WAYS.items() if way != FIRST_SAMPLE)
    return filled(
        'papers/yang/report',
        tables='\n\n'.join(paper_tables(errors, cells)),
        ways='; '.join(told),
        default=default_table(errors, noisy),
        reading=reading,
        off=distance,
        nearer=('the true initial levels', 'the first sample')[int(np.argmin(distance))],
        convergence=convergence_table(figures.followed),
        snr=FOLLOWED_SNR,
    )


def paper_tables(errors: Errors, cells: Sequence[Cell]) -> list[str]:
    """Hold the medians of paper mode against the reference's 95th percentiles."""
    parts = []
    for fitness in dict.fromkeys(cell.fitness for cell in cells):
        own = {cell: references()[cell] for cell in cells if cell.fitness == fitness}
        medians = {cell: np.median(errors[cell, PAPER], axis=0) for cell in own}
        within = [bool((medians[cell] <= reference.p95).all()) for cell, reference in own.items()]
        rows = [
            {
                'window': cell.window,
                'SNR (dB)': decibels(cell.snr_db),
                'our median': figures(medians[cell]),
                "reference's median": figures(reference.median),
                "reference's p95": figures(reference.p95),
                'our median within it': 'yes' if inside else 'no',
                "paper's run": figures(reference.run),
            }
            for (cell, reference), inside in zip(own.items(), within, strict=True)
        ]
        claim = "our median is within the reference's p95 in every cell"
        found = Requirement(claim, f'{sum(within)} of {len(within)}', all(within))
        parts += [f'## Table {TITLES[fitness]}', table(rows), requirements([found])]
    return parts


def default_table(errors: Errors, cells: Sequence[Cell]) -> str:
    """Show the default search beside the Cramér-Rao bound."""
    rows = []
    for cell in cells:
        for way in (PAPER, MEMETIC, DEFAULT):
            bound = noise_of(cell.snr_db) * bounds(cell.window, 6 if way == DEFAULT else 4)
            ratios = rms(errors[cell, way], 0) / bound
            rows.append({
                'window': cell.window,
                'SNR (dB)': decibels(cell.snr_db),
                'search': way,
                'median error': figures(np.median(errors[cell, way], axis=0)),
                'Cramér-Rao bound': figures(bound),
                'RMSE / bound': ' '.join(f'{ratio:.2f}' for ratio in ratios),
            })  # fmt: skip
    return table(rows)


def reading_table(errors: Errors, cells: Sequence[Cell]) -> tuple[str, Array]:
    """Tell which initial h1 and h2 the reference must have been given; and the mean factors."""
    rows, distances = [], []
    for cell in cells:
        reference = references()[cell].median
        true, first = (np.median(errors[cell, way], axis=0) for way in (PAPER, FIRST_SAMPLE))
        distance = off(true, reference), off(first, reference)
        if cell.snr_db <= 0.0:
            distances.append(distance)
        rows.append({
            'window': cell.window,
            'SNR (dB)': decibels(cell.snr_db),
            'true levels': figures(true),
            'first sample': figures(first),
            'reference': figures(reference),
            'true levels off by': f'{distance[0]:.2f}',
            'first sample off by': f'{distance[1]:.2f}',
        })  # fmt: skip
    return table(rows), np.exp(np.mean(np.log(distances), axis=0))


def off(median: Array, reference: Array) -> float:
    """Return the geometric mean of the factors, all taken above 1, between two sets of errors."""
    return float(np.exp(np.mean(np.abs(np.log(median / reference)))))


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


def figures(values: Array) -> str:
    """Return numbers with two significant digits; nothing for NaN."""
    return '-' if np.isnan(values).all() else ' '.join(f'{value:.1e}' for value in values)


def decibels(snr: float) -> str:
    """Return a signal-to-noise ratio as text."""
    return 'no noise' if np.isinf(snr) else f'{snr:g}'
