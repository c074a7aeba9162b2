"""Time of rollouts of plants whose functions choose, beside like ones that do not, in one run.

Work of a candidate-step: one RK4 step and the squared residuals of the outputs, of 64 candidates
over 1000 samples.
"""

from benchmarks.report import publish
from benchmarks.runner import options
from benchmarks.selects.models import PLANTS
from benchmarks.selects.report import report
from benchmarks.selects.run import Row, measured


def main(arguments: list[str] | None = None) -> list[Row]:
    """Measure, print, and write the report."""
    parser = options(__doc__)
    parser.add_argument('--rounds', type=int, default=41, help='interleaved measurements')
    chosen = parser.parse_args(arguments)
    rows = [
        measured(plant, choice, plain, model, chosen.rounds)
        for plant, (plain, models) in PLANTS.items()
        for choice, model in models.items()
    ]
    publish(chosen.results, 'selects', 'Plants that choose', report(rows, chosen.rounds))
    return rows


if __name__ == '__main__':
    main()
