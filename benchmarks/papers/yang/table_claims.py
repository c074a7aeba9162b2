"""The claims of Yang, Li & Dahhou 2020 on the three tanks (sections 5 and 6), judged."""

from itertools import pairwise

import numpy as np

from benchmarks.papers.claims import Claim, Ratio, Verdict, below, every, opposite, verdict, within
from benchmarks.papers.yang.comparisons import (
    as_good,
    combined_p,
    counted,
    errors_ratio,
    listed,
    overall,
    ratio,
)
from benchmarks.papers.yang.reference import FITNESSES, Cell, printed_rows
from benchmarks.papers.yang.run import DEFAULT, HARDEST, LONGER, PAPER, Figures
from benchmarks.papers.yang.starts import score
from benchmarks.tanks import PAPER_WINDOWS, paper_end, paper_levels

LEVEL = 0.05  # probability below which the printed runs are not like ours
SIMILAR = 2.0  # factor of errors
PRINTED_H3 = {name: float(printed_rows()['true', name, ''][3]) for name in ('T2', 'T3')}  # cm
SNRS = (40.0, 20.0, 0.0, -20.0)  # dB, of the tables


def noise_free_parameters(figures: Figures) -> Claim:
    """Judge the fitness functions by p1, p2 and p3 without noise."""
    found = {
        window: ratio(
            *(
                score(figures.errors[Cell(fitness, window, np.inf), PAPER][:, :3])
                for fitness in FITNESSES
            )
        )
        for window in PAPER_WINDOWS
    }
    similar = every(within(own.ends, (1.0 / SIMILAR, SIMILAR)) for own in found.values())
    return Claim(
        '5.2.1, Figs. 4-5, 8-9',
        'without noise both fitness functions estimate the parameters alike',
        f'errors of p, f_t1 over f_t2; holds if within a factor of {SIMILAR:g} in every window',
        listed(found),
        similar,
    )


def noise_free_state(figures: Figures) -> Claim:
    """Judge the fitness functions by h3 without noise."""
    found = {
        window: ratio(*(figures.errors[Cell(f, window, np.inf), PAPER][:, 3] for f in FITNESSES))
        for window in PAPER_WINDOWS
    }
    return Claim(
        '5.2.1, Figs. 6-7, 10-11',
        'without noise f_t1 estimates h3 better than f_t2',
        'errors of h3, f_t1 over f_t2; holds if smaller in every window',
        listed(found),
        every(own.smaller for own in found.values()),
    )


def distance_to_zero(figures: Figures) -> Claim:
    """Judge the distance at the end of the search by that at the truth."""
    own = [cell for cell in figures.cells if cell.fitness == 'ft1' and np.isfinite(cell.snr_db)]
    medians = {
        cell: np.median([solved.distance for solved in figures.solves[cell, PAPER]], axis=0)
        for cell in own
    }
    quiet = max(
        float(
            np.median([s.distance[0] for s in figures.solves[cell._replace(snr_db=np.inf), PAPER]])
        )
        for cell in own
    )
    told = {
        f'{snr:g} dB': f'{np.mean([medians[c][0] for c in own if c.snr_db == snr]):.3g} cm, truth '
        f'{np.mean([medians[c][1] for c in own if c.snr_db == snr]):.3g} cm'
        for snr in SNRS
    }
    return Claim(
        '5.2.2, Fig. 12',
        'even at small SNR the distance converges to its optimum 0',
        'median distance found, mean of the windows; holds if nowhere above that without noise '
        f'({quiet:.3g} cm)',
        listed(told),
        verdict(all(found <= quiet for found, _ in medians.values())),
    )


def correlation_and_noise(figures: Figures) -> Claim:
    """Judge what noise does to either fitness function."""
    growth = {
        f'{fitness} {window}': errors_ratio(
            figures.errors, Cell(fitness, window, -20.0), Cell(fitness, window, 40.0)
        )
        for fitness in FITNESSES
        for window in PAPER_WINDOWS
    }
    larger = every(below(growth[f'ft1 {w}'].ends, growth[f'ft2 {w}'].ends) for w in PAPER_WINDOWS)
    return Claim(
        '5.2.2, Fig. 13',
        'noise affects the correlation more than the distance',
        'errors at -20 dB over those at 40 dB; holds if larger for f_t2 in every window',
        listed(growth),
        larger,
    )


def higher_snr(figures: Figures) -> Claim:
    """Judge every step down in SNR."""
    steps = [
        errors_ratio(figures.errors, Cell(f, window, low), Cell(f, window, high))
        for f in FITNESSES
        for window in PAPER_WINDOWS
        for high, low in pairwise(SNRS)
    ]
    return Claim(
        '5.2.2',
        'the higher the SNR, the better the estimates',
        'errors at each SNR over those at the next higher one; holds if always larger',
        counted(steps),
        every(opposite(step.smaller) for step in steps),
        'errors in proportion to the noise: RMSE / bound in the table of the default search',
    )


def euclidean_better(figures: Figures) -> Claim:
    """Judge the fitness functions cell by cell."""
    found = {cell: fitness_ratio(figures, cell) for cell in noisy(figures)}
    reversed_ = [f'{c.window} {c.snr_db:g} dB' for c, own in found.items() if own.worse]
    return Claim(
        '5.2.2, Tables 1, 2',
        'at the same SNR f_t1 gives better results than f_t2',
        'errors, f_t1 over f_t2; holds if smaller in every cell',
        f'{counted(found.values())}; larger at {", ".join(reversed_) or "none"}',
        every(own.smaller for own in found.values()),
        'least squares, which is maximum likelihood',
    )


def printed_table(figures: Figures, fitness: str, number: int) -> Claim:
    """Judge the printed runs by their rank among ours."""
    own = [cell for cell in figures.cells if cell.fitness == fitness and np.isfinite(cell.snr_db)]
    p = combined_p(figures.errors, own)
    some = sum(as_good(figures.errors, cell)[0] > 0 for cell in own)
    longer = np.median(figures.errors[HARDEST, LONGER][:, 0])
    return Claim(
        f'Table {number}',
        'the algorithm, of 25 individuals and 85 generations, has errors as small as these',
        f'rank of the printed run among {figures.seeds} seeds, from the smallest error, all 12 '
        f'cells together (Fisher 1925); holds if p >= {LEVEL:g}',
        f'p = {p:.1g}; in {some} of 12 cells some seed is as good in all four errors',
        verdict(p >= LEVEL),
        f'p1 at T3, 40 dB: {np.median(figures.errors[HARDEST, DEFAULT][:, 0]):.1e}; the '
        f'algorithm with 500 generations {longer:.1e}' if fitness == 'ft1' else '',
    )  # fmt: skip


def true_levels() -> Claim:
    """Judge the printed true h3 by the stated constants."""
    found = {'T2': float(paper_end('T1')[2]), 'T3': float(paper_end('T2')[2])}
    return Claim(
        'Tables 1, 2',
        f'h3 starts T2 at {PRINTED_H3["T2"]:g} and T3 at {PRINTED_H3["T3"]:g} cm',
        'eq. 16 with the stated constants, steps of 10 ms',
        listed({name: f'{value:.4f} cm' for name, value in found.items()}),
        verdict(all(abs(value - PRINTED_H3[name]) < 0.01 for name, value in found.items())),
    )


def reference_power() -> Claim:
    """Tell what the print leaves open: the power that the SNR counts from, and the sampling."""
    rms = np.sqrt(np.mean(paper_levels('T3')[:, :2] ** 2))
    return Claim(
        'Tables 1, 2',
        'SNR of 40, 20, 0 and -20 dB',
        'unit power and a sample each second are taken here; neither is printed',
        f'deviation of the noise at -20 dB: 10 cm with unit power, {10.0 * rms:.0f} cm with the '
        "outputs' power in T3",
        Verdict.CANNOT_BE_JUDGED,
    )


def on_the_whole(figures: Figures) -> Claim:
    """Judge the conclusion over all cells at once."""
    cells = [cell for cell in figures.cells if cell.fitness == 'ft1']
    own, other = (
        [score(figures.errors[cell._replace(fitness=fitness), PAPER]) for cell in cells]
        for fitness in FITNESSES
    )
    found = overall(own, other)
    return Claim(
        '6',
        'on the whole f_t1 is better than f_t2',
        f'errors, f_t1 over f_t2, geometric mean of all {len(cells)} cells',
        str(found),
        found.smaller,
    )


def noisy(figures: Figures) -> list[Cell]:
    """Return the cells of Table 1."""
    return [cell for cell in figures.cells if cell.fitness == 'ft1' and np.isfinite(cell.snr_db)]


def fitness_ratio(figures: Figures, cell: Cell) -> Ratio:
    """Compare both fitness functions in a cell: f_t1 over f_t2."""
    return errors_ratio(figures.errors, cell._replace(fitness='ft1'), cell._replace(fitness='ft2'))
