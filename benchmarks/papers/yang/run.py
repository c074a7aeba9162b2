"""Solves of the windows of Yang, Li & Dahhou 2020: errors, bounds, and searches followed."""

import functools
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from benchmarks.judge import Judge, values_of
from benchmarks.papers.seeds import seeds_of
from benchmarks.papers.yang.convergence import Followed, follow
from benchmarks.papers.yang.reference import FITNESSES, SNRS, SYMBOLS, Cell
from benchmarks.runner import monte_carlo
from benchmarks.tanks import PAPER_WINDOWS, TankWindow, paper_window
from obs_ros import solve_window
from obs_ros.core.typing import Array
from obs_ros.models.three_tank import THREE_TANK

PAPER, FIRST_SAMPLE, MEMETIC, DEFAULT = 'paper', 'first sample', 'memetic', 'default'
WAYS = {
    PAPER: "the paper's search, the initial h1 and h2 given as they truly are",
    FIRST_SAMPLE: "the paper's search, the first sample of h1 and h2 taken as exact",
    MEMETIC: 'the default search on the same four unknowns',
    DEFAULT: 'the default search on all six unknowns, nothing given',
}
FOLLOWED_SNR = 40.0  # dB


FOLLOWED = 20  # runs, at most

Errors = Mapping[tuple[Cell, str], Array]  # absolute errors (seeds, 4)


class Figures(NamedTuple):
    """All that was measured, of so many seeds for each rate."""

    seeds: int
    cells: Sequence[Cell]
    errors: Errors
    followed: Mapping[tuple[str, str], Followed]


def measure(seeds: int) -> Figures:
    """Solve all cells of both tables, and follow some searches."""
    cells = [Cell(f, w, snr) for f in FITNESSES for w in PAPER_WINDOWS for snr in SNRS]
    followed = follow_all(list(PAPER_WINDOWS), min(FOLLOWED, seeds))
    return Figures(seeds, cells, all_errors(cells, seeds), followed)


def all_errors(cells: Sequence[Cell], seeds: int) -> Errors:
    """Solve every cell in every way that applies to it."""
    first = cells[0].fitness
    pairs = [
        (cell, way)
        for cell in cells
        for way in WAYS
        if way == PAPER
        # Least squares has no other fitness; without noise the first sample is the truth.
        or (cell.fitness == first and not (way == FIRST_SAMPLE and np.isinf(cell.snr_db)))
    ]
    runs = {
        (cell, way): [
            (cell, way, seed)
            for seed in seeds_of('yang', f'{cell.fitness} {cell.window} {cell.snr_db} {way}', seeds)
        ]
        for cell, way in pairs
    }
    found = monte_carlo(errors_of, runs, 'solve', chunk=50)
    return {pair: np.array(errors) for pair, errors in found.items()}


def errors_of(cell: Cell, way: str, seed: int) -> Array:
    """Solve one window and return the absolute errors (4,)."""
    window = paper_window(cell.window, cell.snr_db, seed)
    paper = way in (PAPER, FIRST_SAMPLE)
    estimate = solve_window(
        'three_tank',
        window.record,
        search='chaotic_de' if paper else 'memetic',
        fitness=FITNESSES[cell.fitness] if paper else 'least_squares',
        fixed=given(window, way),
        seed=seed,
    )
    values = values_of(estimate)
    return np.array([abs(values[name] - window.truth[name]) for name in SYMBOLS])


def given(window: TankWindow, way: str) -> dict[str, float] | None:
    """Return the initial levels that the search takes for granted."""
    if way == DEFAULT:
        return None
    if way == FIRST_SAMPLE:
        return dict(zip(('h1', 'h2'), window.record.y[0].tolist(), strict=True))
    return {name: window.truth[name] for name in ('h1', 'h2')}


@functools.cache
def bounds(window_name: str, unknowns: int) -> Array:
    """Return the Cramér-Rao bounds (4,) on standard deviations, per cm of noise."""
    window = paper_window(window_name, np.inf, 0)
    estimated = SYMBOLS if unknowns == len(SYMBOLS) else (*SYMBOLS, 'h1', 'h2')
    judge = Judge(THREE_TANK, window.record, estimated, window.truth)
    return np.sqrt(np.diag(judge.bound(window.truth, 1.0)))[: len(SYMBOLS)]


def follow_all(windows: Sequence[str], runs: int) -> Mapping[tuple[str, str], Followed]:
    """Follow both searches on every window; excesses are medians over the seeds."""
    tasks = {
        (window, method): [
            (window, method, seed) for seed in seeds_of('yang', f'follow {window} {method}', runs)
        ]
        for window in windows
        for method in ('chaotic_de', 'memetic')
    }
    return {
        pair: Followed(own[0].evaluations, np.median([run.excess for run in own], axis=0))
        for pair, own in monte_carlo(followed_one, tasks, 'follow', chunk=4).items()
    }


def followed_one(name: str, method: str, seed: int) -> Followed:
    """Follow one search."""
    fitness = 'euclidean' if method == 'chaotic_de' else 'least_squares'
    return follow(paper_window(name, FOLLOWED_SNR, seed), SYMBOLS, method, fitness, seed)
