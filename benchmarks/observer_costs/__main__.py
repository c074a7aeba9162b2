"""Costs of a sample for each registered observer, and which of them find three free valves.

Costs: the median process time to absorb a sample and fetch the estimate, if one is due, on the
scenario that the observer is for. Three tanks, every parameter free: share of the valve openings
that are right 1000 s after valves have closed in part.
"""

from benchmarks.observer_costs.report import asked, costs_table, valves_table
from benchmarks.observer_costs.run import FILTERS, cost, valves
from benchmarks.report import filled, publish, requirements
from benchmarks.runner import options
from obs_ros.observers.base import OBSERVERS


def main(arguments: list[str] | None = None) -> None:
    """Measure, print, and write the report."""
    parser = options(__doc__)
    parser.add_argument('--samples', type=int, default=2000, help='samples of each observer')
    parser.add_argument('--seeds', type=int, default=10, help='noises of the three tanks')
    chosen = parser.parse_args(arguments)
    costs = [cost(name, chosen.samples) for name in OBSERVERS]
    found = valves_table([valves(name, chosen.seeds) for name in FILTERS], chosen.seeds)
    text = filled(
        'observer_costs/report',
        costs=costs_table(costs),
        asked=requirements(asked(costs)),
        valves=found,
    )
    publish(chosen.results, 'observer_costs', 'Observers: cost, and free valves', text)


if __name__ == '__main__':
    main()
