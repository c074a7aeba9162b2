"""The runs of all observers on all scenarios of Gremling & Passino 2000, and what a run counts."""

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import NamedTuple

from benchmarks.papers.gremling.counts import draws, operations
from benchmarks.papers.gremling.kalman import Configuration, configurations, unstable
from benchmarks.papers.gremling.plan import BASE_2, DEFAULT, JETS, LINEAR, Outcomes, ways
from benchmarks.papers.observed import observe, runs_of
from benchmarks.papers.seeds import seeds_of
from benchmarks.runner import monte_carlo

MEANS = 50  # runs of a mean, as in the paper's Tables 1 and 2
OTHERS = 20  # of the default and of base 2, at most
GENERATIONS = 200  # whose random numbers are counted


class Figures(NamedTuple):
    """Outcomes by scenario and observer; unstable filters; operations, and draws by generation."""

    outcomes: Outcomes
    filters: Mapping[Configuration, bool]
    operations: tuple[Counter[str], Counter[str]]  # of eqs. 4-5 alone, of all
    draws: Sequence[Counter[str]]


def measure(seeds: int) -> Figures:
    """Return the figures, of so many seeds for each rate: of the jet engine; means have fewer."""
    cells = {
        (scenario, way.label): runs_of('gremling', scenario, way, count(scenario, way.label, seeds))
        for scenario in (*LINEAR, *JETS)
        for way in ways(scenario)
    }
    tried = [one for scenario in JETS for one in configurations(scenario)]
    found = monte_carlo(unstable, {'filters': [(one,) for one in tried]}, 'filters', chunk=8)
    return Figures(
        monte_carlo(observe, cells, 'gremling'),
        dict(zip(tried, found['filters'], strict=True)),
        operations(),
        draws(GENERATIONS, *seeds_of('gremling', 'draws', 1)),
    )


def count(scenario: str, label: str, seeds: int) -> int:
    """Return how many runs a cell has, if anything is random there."""
    if label in (DEFAULT, BASE_2):
        return min(seeds, OTHERS)
    return seeds if scenario in JETS else min(seeds, MEANS)
