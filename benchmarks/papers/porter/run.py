"""The runs of all observers on all scenarios of Porter & Passino 1995."""

from benchmarks.papers.observed import observe, runs_of
from benchmarks.papers.porter.plan import SCENARIOS, Outcomes, ways
from benchmarks.runner import monte_carlo


def measure(seeds: int) -> Outcomes:
    """Return outcomes by scenario and observer, of so many seeds where anything is random."""
    cells = {
        (scenario, way.label): runs_of('porter', scenario, way, seeds)
        for scenario in SCENARIOS
        for way in ways(scenario)
    }
    return monte_carlo(observe, cells, 'porter', chunk=4)
