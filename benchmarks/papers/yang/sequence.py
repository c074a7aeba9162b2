"""Windows in sequence, as section 4.4.2 has them: one individual inherited, smaller populations."""

from collections.abc import Mapping, Sequence

import numpy as np

from benchmarks.judge import values_of
from benchmarks.papers.seeds import seeds_of
from benchmarks.papers.yang.reference import SYMBOLS
from benchmarks.papers.yang.starts import score
from benchmarks.runner import monte_carlo
from benchmarks.tanks import (
    PAPER_SAMPLES,
    PAPER_WINDOWS,
    measured,
    paper_end,
    paper_levels,
    simulated,
)
from obs_ros import Record, solve_window
from obs_ros.core.typing import Array

SNR = 40.0  # dB
UNCHANGED = 'T3 again'  # the 1000 s after T3, with the valves as they were
PERIODS = (*PAPER_WINDOWS, UNCHANGED)
LATER = PERIODS[1:]
COLD, WARM, SMALL = 'cold, Np 25', 'warm, Np 25', 'warm, Np 15'
WAYS = {
    COLD: (False, 25),
    WARM: (True, 25),
    SMALL: (True, 15),
    'warm, Np 10': (True, 10),
}

Sequences = Mapping[str, Array]  # by way: geometric means of the four errors (seeds, periods)


def sequences(seeds: int) -> Sequences:
    """Solve the four windows one after the other, in every way."""
    runs = {
        way: [(*how, seed) for seed in seeds_of('yang', f'sequence, {way}', seeds)]
        for way, how in WAYS.items()
    }
    return {way: np.array(own) for way, own in monte_carlo(solved, runs, 'sequence', 10).items()}


def solved(warm: bool, later_population: int, seed: int) -> list[float]:
    """Solve one sequence; windows after the first have `later_population` individuals."""
    found, previous = [], None
    rng = np.random.default_rng([seed, 1])
    for number, name in enumerate(PERIODS):
        t = np.arange(float(PAPER_SAMPLES))
        levels, p = truth_of(name)
        window = measured(t, levels, p, SNR, rng)
        estimate = solve_window(
            'three_tank',
            Record(t + number * PAPER_SAMPLES, window.record.u, window.record.y),
            search='chaotic_de',
            fitness='euclidean',
            fixed={level: window.truth[level] for level in ('h1', 'h2')},
            previous=previous if warm else None,
            search_options={'population': later_population if number else 25},
            seed=seed + number,
        )
        values = values_of(estimate)
        errors = np.array([abs(values[symbol] - window.truth[symbol]) for symbol in SYMBOLS])
        found.append(float(score(errors)))
        previous = estimate
    return found


def truth_of(name: str) -> tuple[Array, Array]:
    """Return the true levels (K, 3) in cm and openings (3,) of a period."""
    if name != UNCHANGED:
        return paper_levels(name), np.array(PAPER_WINDOWS[name])
    p = np.array(PAPER_WINDOWS['T3'])
    return simulated(paper_end('T3'), p, np.arange(float(PAPER_SAMPLES))), p


def scores(found: Sequences, way: str, period: str) -> Sequence[float]:
    """Return the geometric means of the errors of one way in one period."""
    return [float(value) for value in found[way][:, PERIODS.index(period)]]
