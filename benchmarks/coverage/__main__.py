"""Coverage of published intervals where windows tell little and where they tell much.

Twelve exact plants under poor and rich inputs, windows alone and in sequence; true profile
likelihoods beside those of poor windows; process times beside those of another tree.
"""

from pathlib import Path

from benchmarks.coverage.cost import compared
from benchmarks.coverage.reference import profiled
from benchmarks.coverage.report import (
    acceptance,
    cost_table,
    coverage_table,
    parameters_table,
    reference_table,
)
from benchmarks.coverage.run import IN_RUN, KINDS, WAYS, tracked
from benchmarks.coverage.scores import NARROW
from benchmarks.report import filled, publish, requirements
from benchmarks.runner import monte_carlo, options
from benchmarks.zoo.experiments import EXPERIMENTS

QUICK = {'windows': 40, 'referred': 10, 'timed': 4}


def main(arguments: list[str] | None = None) -> str:
    """Solve, count, print, and write the report."""
    parser = options(__doc__, shared=True)
    parser.add_argument('--windows', type=int, default=400, help='of each cell')
    parser.add_argument('--referred', type=int, default=60, help='poor ones that are profiled')
    parser.add_argument('--timed', type=int, default=20, help='of each cell, with both trees')
    parser.add_argument('--seed', type=int, default=120_000, help='of the first window')
    parser.add_argument('--plants', nargs='+', default=list(EXPERIMENTS), choices=EXPERIMENTS)
    parser.add_argument('--against', type=Path, help='another source tree, to compare times with')
    parser.add_argument('--quick', action='store_true', help=f'{QUICK} of each cell')
    chosen = parser.parse_args(arguments)
    if chosen.quick:
        vars(chosen).update(QUICK)
    seed, plants = chosen.seed, chosen.plants
    runs = {False: range(chosen.windows), True: range(-(-chosen.windows // IN_RUN))}
    cells = {
        (name, rich, way): [(name, rich, way, seed + i) for i in runs[way]]
        for name in plants for rich in KINDS for way in WAYS
    }  # fmt: skip
    tracks = monte_carlo(tracked, cells, 'windows', chunk=2)
    referred = range(min(chosen.referred, chosen.windows))
    profiles = monte_carlo(
        profiled, {name: [(name, False, seed + i) for i in referred] for name in plants}, 'profiles'
    )
    costs = compared(chosen.against, plants, chosen.timed, seed) if chosen.against else {}
    text = filled(
        'coverage/report',
        windows=chosen.windows,
        in_run=IN_RUN,
        seed=seed,
        plants=len(plants),
        referred=len(referred),
        narrow=NARROW,
        acceptance=requirements(acceptance(tracks, profiles, costs)),
        coverage=coverage_table(tracks),
        parameters=parameters_table(tracks),
        reference=reference_table(tracks, profiles),
        cost=cost_table(costs),
    )
    return publish(chosen.results, 'coverage', 'Coverage of published intervals', text)


if __name__ == '__main__':
    main()
