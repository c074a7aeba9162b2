"""Time of rollouts of one plant by each way in which people write its function, on both backends.

Work of a candidate-step: one RK4 step and the squared residuals of the outputs, of 64 candidates.
"""

from benchmarks.report import publish
from benchmarks.runner import options
from benchmarks.writings.report import report
from benchmarks.writings.run import Row, measured


def main(arguments: list[str] | None = None) -> list[Row]:
    """Measure, print, and write the report."""
    parser = options(__doc__)
    parser.add_argument('--rounds', type=int, default=41, help='interleaved measurements')
    chosen = parser.parse_args(arguments)
    rows = measured(chosen.rounds)
    title = 'Functions as people write them'
    publish(chosen.results, 'writings', title, report(rows, chosen.rounds))
    return rows


if __name__ == '__main__':
    main()
