"""Time of rollouts of a spring by the functions in its model, beside C and another source tree.

Work of a candidate-step: one step and the squared residual of the output, of 64 candidates over
1000 samples. Beside it, the errors of compiled functions, and the time of the first compilation.
"""

import tempfile
from pathlib import Path

from benchmarks.functions.accuracy import errors
from benchmarks.functions.compilation import compilations
from benchmarks.functions.models import FUNCTIONS
from benchmarks.functions.report import report
from benchmarks.functions.run import C_OPTIONS, Row, rows_of
from benchmarks.report import publish
from benchmarks.runner import gcc_version, options

PARTS = 'times', 'errors', 'compilation'
ROSENBROCK = ['where', 'interp', 'exp', 'sin', 'power']  # measured in linearly implicit steps, too
# What --quick measures in place of the defaults: it shows that all works, and no figure.
QUICK = {'rounds': 3, 'points': 1000, 'starts': 1, 'functions': ['where', 'sin']}


def main(arguments: list[str] | None = None) -> list[Row]:
    """Measure the parts that are chosen, print, and write the report."""
    parser = options(__doc__)
    parser.add_argument('--rounds', type=int, default=41, help='interleaved measurements')
    parser.add_argument('--points', type=int, default=200_000, help='at which errors are measured')
    parser.add_argument('--starts', type=int, default=3, help='processes that compile a model')
    parser.add_argument('--seed', type=int, default=180_000, help='of the points')
    parser.add_argument(
        '--functions', nargs='+', choices=FUNCTIONS, default=list(FUNCTIONS), help='some'
    )
    parser.add_argument('--only', choices=PARTS, nargs='+', default=list(PARTS), help='some parts')
    parser.add_argument('--against', type=Path, help='another source tree, to compare times with')
    parser.add_argument('--quick', action='store_true', help=f'{QUICK}, to see that it works')
    chosen = parser.parse_args(arguments)
    if chosen.quick:
        vars(chosen).update(QUICK)
    rows = []
    if 'times' in chosen.only:
        implicit = [name for name in ROSENBROCK if name in chosen.functions]
        with tempfile.TemporaryDirectory() as folder:
            ways = chosen.rounds, Path(folder), chosen.against
            rows = [
                *rows_of(chosen.functions, 'rk4', *ways),
                *rows_of(implicit, 'rosenbrock', *ways),
            ]
    accuracy = errors(chosen.points, chosen.seed) if 'errors' in chosen.only else []
    starts = compilations(chosen.starts, chosen.against) if 'compilation' in chosen.only else []
    version = gcc_version()
    compiler = f'gcc {version} {" ".join(C_OPTIONS)}' if version else 'no gcc'
    text = report(rows, accuracy, starts, chosen.rounds)
    publish(chosen.results, 'functions', 'Functions in models', text, compiler)
    return rows


if __name__ == '__main__':
    main()
