"""The genetic observers of Porter & Passino 1995 and Gremling & Passino 2000, reproduced.

Errors beside those in print and beside plainer observers on the same plants, over many
seeds, and the papers' figures. A run is a seed of the genetic algorithm, and of the input where
that is random.
"""

from functools import partial

from benchmarks.genetic_papers.pictures import draw_gao, draw_gase
from benchmarks.genetic_papers.plan import Outcomes, plan_1995, plan_2000
from benchmarks.genetic_papers.report import report
from benchmarks.genetic_papers.run import run
from benchmarks.report import pictures, publish
from benchmarks.runner import monte_carlo, options


def main(arguments: list[str] | None = None) -> Outcomes:
    """Run, print, and write the report with its pictures."""
    parser = options(__doc__, shared=True)
    parser.add_argument(
        '--seeds', type=int, default=30, help='runs per scenario of the first paper'
    )
    parser.add_argument('--runs', type=int, default=20, help="runs of the second's paper mode")
    parser.add_argument('--others', type=int, default=5, help='runs of its other cases')
    chosen = parser.parse_args(arguments)
    runs = plan_1995(chosen.seeds) | plan_2000(chosen.runs, chosen.others)
    outcomes = monte_carlo(run, runs, 'run')
    drawn = {
        'genetic_papers_gao.png': (
            'Porter & Passino, figures 1 to 12', partial(draw_gao, outcomes)
        ),
        'genetic_papers_gase.png': (
            'Gremling & Passino, figures 2 to 5', partial(draw_gase, outcomes)
        ),
    }  # fmt: skip
    text = report(outcomes, chosen.runs, pictures(chosen.results, drawn))
    title = 'Genetic observers: Porter & Passino 1995 and Gremling & Passino 2000'
    publish(chosen.results, 'genetic_papers', title, text)
    return outcomes


if __name__ == '__main__':
    main()
