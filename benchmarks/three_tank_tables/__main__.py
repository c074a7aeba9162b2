"""Tables 1 and 2 of Yang, Li & Dahhou 2020, over many seeds, beside those in print.

Paper mode: chaotic DE, rand/1/bin, cubic map, 25 individuals, 85 generations; p1, p2, p3 and the
initial h3 unknown, the initial h1 and h2 given. Beside it the default search and the Cramér-Rao
bound.
"""

from functools import partial

from benchmarks.report import pictures, publish
from benchmarks.runner import options
from benchmarks.tanks import PAPER_WINDOWS
from benchmarks.three_tank_tables.pictures import draw_convergence, draw_errors
from benchmarks.three_tank_tables.reference import FITNESSES, SNRS, Cell
from benchmarks.three_tank_tables.report import report
from benchmarks.three_tank_tables.run import Errors, all_errors, follow_all

QUICK_SNRS = (40.0, 0.0)


def main(arguments: list[str] | None = None) -> Errors:
    """Solve, print, and write the report with its two pictures."""
    parser = options(__doc__, shared=True)
    parser.add_argument('--seeds', type=int, default=50, help='noises and searches per cell')
    parser.add_argument('--quick', action='store_true', help='20 seeds, ft1 only, 40 and 0 dB')
    parser.add_argument('--windows', nargs='+', choices=PAPER_WINDOWS, default=[*PAPER_WINDOWS])
    chosen = parser.parse_args(arguments)
    seeds = range(min(chosen.seeds, 20) if chosen.quick else chosen.seeds)
    snrs = QUICK_SNRS if chosen.quick else SNRS
    fitnesses = ('ft1',) if chosen.quick else tuple(FITNESSES)
    cells = [Cell(f, w, snr) for f in fitnesses for w in chosen.windows for snr in snrs]
    errors = all_errors(cells, seeds)
    followed = follow_all(chosen.windows, range(min(20, len(seeds))))
    name = 'three_tank_tables_quick' if chosen.quick else 'three_tank_tables'
    drawn = {
        f'{name}_errors.png': ('error against SNR', partial(draw_errors, errors, cells)),
        f'{name}_convergence.png': ('convergence', partial(draw_convergence, followed)),
    }
    text = report(errors, cells, followed, len(seeds), pictures(chosen.results, drawn))
    publish(chosen.results, name, 'Three tanks: Tables 1 and 2 of Yang, Li & Dahhou 2020', text)
    return errors


if __name__ == '__main__':
    main()
