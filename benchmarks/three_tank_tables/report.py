"""Tables of the windows of Yang, Li & Dahhou 2020."""

from collections.abc import Mapping, Sequence

import numpy as np

from benchmarks.report import Requirement, requirements, rms, table
from benchmarks.tanks import noise_of
from benchmarks.three_tank_tables.convergence import LAST_EVALUATIONS, Followed
from benchmarks.three_tank_tables.reference import TRUTH_NOTE, Cell, references
from benchmarks.three_tank_tables.run import (
    DEFAULT,
    FIRST_SAMPLE,
    FOLLOWED_SNR,
    MEMETIC,
    PAPER,
    WAYS,
    Errors,
    bounds,
)
from obs_ros.core.typing import Array

TITLES = {'ft1': '1 (f_t1, euclidean)', 'ft2': '2 (f_t2, correlation)'}


def report(
    errors: Errors, cells: Sequence[Cell], followed: Mapping[tuple[str, str], Followed], seeds: int
) -> list[str]:
    """Return the parts of the report."""
    one_fitness = [cell for cell in cells if cell.fitness == cells[0].fitness]
    noisy = [cell for cell in one_fitness if np.isfinite(cell.snr_db)]
    return [
        introduction(seeds),
        TRUTH_NOTE,
        *paper_tables(errors, cells),
        default_table(errors, noisy),
        reading_table(errors, noisy),
        convergence_table(followed),
    ]


def introduction(seeds: int) -> str:
    """Say what was done."""
    return (
        f'{seeds} seeds of noise and search per cell; windows of 1000 samples, 1 s apart, sigma = '
        '10^(-SNR/20) cm, truth integrated with steps of 10 ms. Paper mode: cubic map, rand/1/bin, '
        'F = CR = 0.7, 25 individuals, 85 generations, out of the box drawn again; p1, p2, p3 and '
        'the initial h3 are unknown, the initial h1 and h2 are given as they truly are. All '
        'errors: absolute, of p1 p2 p3 (1) and h3 (cm). The reference is '
        'benchmarks/three_tank_tables/reference.csv.'
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
    ways = '; '.join(f'`{way}`: {meaning}' for way, meaning in WAYS.items() if way != FIRST_SAMPLE)
    return (
        f'## The default search and the Cramér-Rao bound\n\n{ways}. The bound is that of as many '
        'unknowns (4 or 6). In T1 the truth lies on the bounds of the box (p = 1, h1 = h2 = 0): '
        'errors are cut off there and may be below it; and where levels cross, in T1, the '
        "model's steps of 1 s err by up to 3e-3 cm, which shows at 40 dB.\n\n" + table(rows)
    )


def reading_table(errors: Errors, cells: Sequence[Cell]) -> str:
    """Tell which initial h1 and h2 the reference must have been given."""
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
    return (
        '## Which initial h1 and h2 were given?\n\nThe paper does not say. Medians of paper mode '
        'with the true initial levels and with the first sample taken as exact; off by: mean '
        'factor between our medians and those of the reference.\n\n'
        + table(rows)
        + '\n\n'
        + conclusion(np.exp(np.mean(np.log(distances), axis=0)))
    )


def conclusion(distance: Array) -> str:
    """Say which reading reproduces the reference, by mean factors: true levels, first sample."""
    nearer = ('the true initial levels', 'the first sample')[int(np.argmin(distance))]
    return (
        f'At 0 dB and below, where it matters: off by {distance[0]:.2f} with the true initial '
        f'levels and by {distance[1]:.2f} with the first sample. So the reference was given '
        f'{nearer}; a first sample taken as exact adds its own noise to h3.'
    )


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
    return (
        f'## Convergence at {FOLLOWED_SNR:g} dB\n\nExcess of the sum of squares over the optimum '
        '(found by scipy, truth among the starts) in sigma^2, median over the seeds, four '
        'unknowns. Every candidate counts as one, though the default search rolls many out over a '
        'part of the window only; `inf`: none yet over the whole window.\n\n' + table(rows)
    )


def figures(values: Array) -> str:
    """Return numbers with two significant digits; nothing for NaN."""
    return '-' if np.isnan(values).all() else ' '.join(f'{value:.1e}' for value in values)


def decibels(snr: float) -> str:
    """Return a signal-to-noise ratio as text."""
    return 'no noise' if np.isinf(snr) else f'{snr:g}'
