"""First populations: chaotic maps beside plain random ones, in the paper's and the default search.

Section 4.1: "applying chaotic sequence instead of random sequence in DE is powerful and efficient".
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from benchmarks.judge import values_of
from benchmarks.papers.seeds import seeds_of
from benchmarks.papers.yang.reference import SYMBOLS
from benchmarks.runner import monte_carlo
from benchmarks.tanks import PAPER_WINDOWS, paper_window
from obs_ros import solve_window
from obs_ros.core.typing import Array
from obs_ros.optimization.initial_population import POPULATIONS

SNR = 40.0  # dB
UNIFORM, CUBIC = 'uniform', 'cubic'
PAPER, DEFAULT = 'paper', 'default'
NO_EVOLUTION = 'uniform, no evolution'  # of the default search: random points, then descent


class Start(NamedTuple):
    """A search from one kind of population: geometric mean of its four errors, and its rollouts."""

    error: float
    evaluations: int


Starts = Mapping[tuple[str, str, str], Sequence[Start]]  # by search, start and window


def starts(seeds: int) -> Starts:
    """Search the three windows from every kind of population, by default from three of them."""
    kinds = [
        *((PAPER, kind) for kind in POPULATIONS),
        *((DEFAULT, kind) for kind in (CUBIC, UNIFORM, NO_EVOLUTION)),
    ]
    runs = {
        (search, kind, window): [
            (search, kind, window, seed)
            for seed in seeds_of('yang', f'{search} from {kind}, {window}', seeds)
        ]
        for search, kind in kinds
        for window in PAPER_WINDOWS
    }
    return monte_carlo(started, runs, 'starts', chunk=25)


def started(search: str, kind: str, name: str, seed: int) -> Start:
    """Search one window for p1, p2, p3 and h3 from one population."""
    window = paper_window(name, SNR, seed)
    paper = search == PAPER
    options: dict[str, str | int] = {'chaos': UNIFORM if kind == NO_EVOLUTION else kind}
    if kind == NO_EVOLUTION:
        options['generations'] = 0
    estimate = solve_window(
        'three_tank',
        window.record,
        search='chaotic_de' if paper else 'memetic',
        fitness='euclidean' if paper else 'least_squares',
        fixed={level: window.truth[level] for level in ('h1', 'h2')},
        seed=seed,
        search_options=options,
    )
    values = values_of(estimate)
    errors = np.array([abs(values[symbol] - window.truth[symbol]) for symbol in SYMBOLS])
    return Start(float(score(errors)), estimate.evaluations)


def errors_from(found: Starts, search: str, kind: str, window: str) -> list[float]:
    """Return the geometric means of the errors of a search from one kind of start."""
    return [start.error for start in found[search, kind, window]]


def score(errors: Array) -> Array:
    """Return the geometric mean over the last axis: a factor in any unit counts the same."""
    with np.errstate(divide='ignore'):
        return np.asarray(np.exp(np.mean(np.log(errors), axis=-1)))
