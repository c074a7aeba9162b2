"""Plants that are stiff, slow or kinked, and no step to choose: every figure asked of integration.

Windows solved beside an independent implicit integrator, error beside time of each method, filters,
tanks whose levels cross, and the time of plants that need none of this beside another source tree.
"""

from functools import partial
from pathlib import Path

from benchmarks.integrators import cost, curves, filters, kinks, pictures, report, run
from benchmarks.integrators.plants import PLANTS
from benchmarks.report import filled, publish, requirements
from benchmarks.report import pictures as saved
from benchmarks.runner import monte_carlo, options, progress
from benchmarks.zoo import CASES

PARTS = 'windows', 'curves', 'kinks', 'filters', 'cost'
# What --quick measures in place of the defaults: it shows that all works, and no rate.
QUICK = {'windows': 4, 'kinked': 40, 'timed': 2}


def main(arguments: list[str] | None = None) -> str:
    """Measure the parts that are chosen, print, and write the report."""
    parser = options(__doc__, shared=True)
    parser.add_argument('--windows', type=int, default=50, help='of each plant')
    parser.add_argument('--kinked', type=int, default=400, help='windows of kinked tanks')
    parser.add_argument('--timed', type=int, default=6, help='windows of each case of the cost')
    parser.add_argument('--seed', type=int, default=170_000, help='of the first window')
    parser.add_argument('--plants', nargs='+', choices=PLANTS, default=list(PLANTS), help='some')
    parser.add_argument('--only', choices=PARTS, nargs='+', default=list(PARTS), help='some parts')
    parser.add_argument('--against', type=Path, help='another source tree, to compare times with')
    parser.add_argument('--quick', action='store_true', help=f'{QUICK}, to see that it works')
    chosen = parser.parse_args(arguments)
    if chosen.quick:
        vars(chosen).update(QUICK)
    seeds = range(chosen.seed, chosen.seed + chosen.windows)

    def wanted(part: str) -> bool:
        return part in chosen.only

    cells = {name: [(name, seed) for seed in seeds] for name in chosen.plants if wanted('windows')}
    found = monte_carlo(run.solved, cells, 'windows') if cells else {}
    levels = [(chosen.seed + i,) for i in range(chosen.kinked if wanted('kinks') else 0)]
    kinked = monte_carlo(kinks.solved, {'': levels}, 'kinks', chunk=8)[''] if levels else []
    runs = [
        (plant, name, seed)
        for plant in filters.FOLLOWED
        for name in filters.FILTERS
        for seed in seeds[: max(1, chosen.windows // 5)]
    ]
    followed = monte_carlo(filters.solved, {'': runs}, 'filters')[''] if wanted('filters') else []
    shown = progress(curves.SHOWN, 'curves', len(curves.SHOWN)) if wanted('curves') else ()
    points = [point for name in shown for point in curves.points(name)]
    costs: cost.Costs = {}
    if wanted('cost') and chosen.against:
        costs = cost.compared(chosen.against, list(CASES), chosen.timed, chosen.seed)
    drawn = {'integrators_curves.png': ('Error beside time', partial(pictures.errors, points))}
    text = filled(
        'integrators/report',
        windows=chosen.windows,
        seed=chosen.seed,
        rtol=run.RTOL,
        fine=run.FINE,
        lanes=curves.LANES,
        shown=report.SHOWN,
        acceptance=requirements(report.rows(found, kinked, followed, costs)),
        plants=report.plants(found),
        failures=report.failures(found),
        kinks=report.outcomes(one.outcome for one in kinked) or 'Not measured.',
        filters=report.filter_table(followed),
        curves=report.curves(points),
        pictures=saved(chosen.results, drawn) if points else '',
        cost=report.cost(costs),
    )
    return publish(chosen.results, 'integrators', 'Any plant, and no step to choose', text)


if __name__ == '__main__':
    main()
