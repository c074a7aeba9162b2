"""Time of the compiled three-tank rollout beside C and NumPy, and of the filter's pass, in one run.

Work of a candidate-step: one RK4 step and the squared residuals of two outputs. All three are
called from Python, their arguments laid out anew (ours) or ready (C): with windows of 1000 samples
a call takes 0.1 ms or more, so that the cost of the call itself does not show.
"""

from benchmarks.c_twin import C_OPTIONS
from benchmarks.kernel.report import report
from benchmarks.kernel.run import Row, filter_pass, rows_of
from benchmarks.report import publish
from benchmarks.runner import gcc_version, options


def main(arguments: list[str] | None = None) -> list[Row]:
    """Measure, print, and write the report."""
    parser = options(__doc__)
    parser.add_argument('--samples', type=int, default=1000, help='of the window')
    parser.add_argument('--rounds', type=int, default=41, help='interleaved measurements')
    chosen = parser.parse_args(arguments)
    rows = rows_of(chosen.samples, chosen.rounds)
    version = gcc_version()
    compiler = f'gcc {version} {" ".join(C_OPTIONS)}' if version else 'no gcc'
    text = report(rows, filter_pass(chosen.samples, chosen.rounds), chosen.rounds)
    publish(chosen.results, 'kernel', 'Rollout kernel', text, compiler)
    return rows


if __name__ == '__main__':
    main()
