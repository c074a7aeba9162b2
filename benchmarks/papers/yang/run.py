"""Solves of the windows of Yang, Li & Dahhou 2020: errors, fitness, bounds, searches followed."""

import functools
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from benchmarks.judge import Judge, values_of
from benchmarks.papers.seeds import seeds_of
from benchmarks.papers.yang.convergence import Followed, follow
from benchmarks.papers.yang.reference import FITNESSES, SNRS, SYMBOLS, Cell
from benchmarks.papers.yang.sequence import Sequences, sequences
from benchmarks.papers.yang.starts import Starts, starts
from benchmarks.papers.yang.theorem import Collapse, collapses
from benchmarks.runner import cpu_seconds, monte_carlo
from benchmarks.tanks import PAPER_SAMPLES, PAPER_WINDOWS, TankWindow, paper_window
from obs_ros import Estimate, solve_window
from obs_ros.core.typing import Array
from obs_ros.models.three_tank import THREE_TANK

NAME = 'yang'
PAPER, FIRST_SAMPLE, DEFAULT = 'paper', 'first sample', 'default'
LONGER = 'paper, 500 generations'
WAYS = {
    PAPER: "the paper's search, the initial h1 and h2 given as they truly are",
    FIRST_SAMPLE: "the paper's search, the first sample of h1 and h2 taken as exact",
    DEFAULT: 'the default search on all six unknowns, nothing given',
    LONGER: "the paper's search with 500 generations in place of 85",
}
SEARCHES = (PAPER, FIRST_SAMPLE, LONGER)
HARDEST = Cell('ft1', 'T3', 40.0)  # of the cells in which the search is the limit, not the noise
FOLLOWED_SNR = 40.0  # dB
FOLLOWED = 20  # runs, at most
QUICK = 0.01  # of a window's length: far more than a search takes, on any machine


class Solved(NamedTuple):
    """One window solved.

    Absolute errors (4,) of p1, p2, p3 (1) and h3 (cm); the Euclidean distance (cm) and the sum of
    the correlations (1), each of the estimate and of the truth, from the measured outputs.
    """

    errors: Array
    distance: tuple[float, float]
    correlation: tuple[float, float]


Solves = Mapping[tuple[Cell, str], Sequence[Solved]]
Errors = Mapping[tuple[Cell, str], Array]  # absolute errors (seeds, 4)


class Figures(NamedTuple):
    """All that was measured, of so many seeds for each rate."""

    seeds: int
    cells: Sequence[Cell]
    solves: Solves
    starts: Starts
    sequences: Sequences
    collapses: Mapping[str, Sequence[Collapse]]
    followed: Mapping[tuple[str, str], Followed]
    quick: bool  # a search takes less than QUICK of its window in process time

    @property
    def errors(self) -> Errors:
        """The errors alone."""
        return {
            pair: np.array([solved.errors for solved in own]) for pair, own in self.solves.items()
        }


def measure(seeds: int) -> Figures:
    """Solve all cells of both tables, and what else the claims need."""
    cells = [Cell(f, w, snr) for f in FITNESSES for w in PAPER_WINDOWS for snr in SNRS]
    return Figures(
        seeds,
        cells,
        all_solves(cells, seeds),
        starts(seeds),
        sequences(seeds),
        collapses(seeds),
        follow_all(list(PAPER_WINDOWS), min(FOLLOWED, seeds)),
        is_quick(),
    )


def is_quick() -> bool:
    """Tell whether the paper's search takes less than QUICK of its window in process time."""
    solved(HARDEST, PAPER, 0)  # compiles
    return cpu_seconds(lambda: solved(HARDEST, PAPER, 1)) < QUICK * PAPER_SAMPLES


def all_solves(cells: Sequence[Cell], seeds: int) -> Solves:
    """Solve every cell in every way that applies to it."""
    pairs = [(cell, way) for cell in cells for way in WAYS if applies(cell, way)]
    runs = {
        (cell, way): [
            (cell, way, seed) for seed in seeds_of(NAME, f'{scenario_of(cell)}, {way}', seeds)
        ]
        for cell, way in pairs
    }
    return monte_carlo(solved, runs, 'windows', chunk=25)


def applies(cell: Cell, way: str) -> bool:
    """Tell whether a way is tried on a cell."""
    if way == PAPER:
        return True
    if way == LONGER:
        return cell == HARDEST
    if way == FIRST_SAMPLE:
        return cell.fitness == 'ft1' and cell.snr_db <= 0.0
    # Least squares has no other fitness, and is told what the noise is by the residuals.
    return cell.fitness == 'ft1' and bool(np.isfinite(cell.snr_db))


def scenario_of(cell: Cell) -> str:
    """Return a cell's name."""
    return f'{cell.fitness} {cell.window} {cell.snr_db:g} dB'


def solved(cell: Cell, way: str, seed: int) -> Solved:
    """Solve one window; the seed is that of its noise and of the search."""
    window = paper_window(cell.window, cell.snr_db, seed)
    paper = way in SEARCHES
    estimate = solve_window(
        'three_tank',
        window.record,
        search='chaotic_de' if paper else 'memetic',
        fitness=FITNESSES[cell.fitness] if paper else 'least_squares',
        fixed=given(window, way),
        seed=seed,
        search_options={'generations': 500} if way == LONGER else None,
    )
    return Solved(errors_of(estimate, window), *fitnesses(estimate, window))


def errors_of(estimate: Estimate, window: TankWindow) -> Array:
    """Return the absolute errors (4,)."""
    values = values_of(estimate)
    return np.array([abs(values[name] - window.truth[name]) for name in SYMBOLS])


def fitnesses(
    estimate: Estimate, window: TankWindow
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return -f_t1 and f_t2 (section 5.1), each of the estimate and of the truth."""
    y = window.record.y
    outputs = (estimate.states[:, :2], window.levels[:, :2])
    distances = [float(np.linalg.norm(y - own, axis=0).sum()) for own in outputs]
    correlations = [
        sum(float(np.corrcoef(y[:, i], own[:, i])[0, 1]) for i in range(2)) for own in outputs
    ]
    return (distances[0], distances[1]), (correlations[0], correlations[1])


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
            (window, method, seed) for seed in seeds_of(NAME, f'follow {window} {method}', runs)
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
