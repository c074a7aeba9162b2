"""Windows in sequence: their intervals and alarms held against the truth, and their cost.

Random runs of the three tanks and of a first-order lag, solved window by window with the arrival
cost of earlier windows, beside other ways to use them. All runs are simulated with steps a
hundredth of the samples' interval.
"""

from functools import partial

from benchmarks.report import pictures, publish
from benchmarks.runner import options
from benchmarks.sequence.pictures import draw_calibration, draw_jumps, draw_story
from benchmarks.sequence.report import report
from benchmarks.sequence.run import PER_CELL, carried_out, compile_all, plan, timed_scenes


def main(arguments: list[str] | None = None) -> str:
    """Solve, count, print, and write the report."""
    parser = options(__doc__)
    parser.add_argument(
        '--windows',
        type=int,
        default=PER_CELL,
        help='in each clean cell, about; the other tables in proportion',
    )
    parser.add_argument('--seed', type=int, default=90_000, help='of the first run')
    chosen = parser.parse_args(arguments)
    windows, seed = chosen.windows, chosen.seed
    compile_all(seed)
    measured = carried_out(plan(windows, seed), timed_scenes(windows, seed))
    drawn = {
        'sequence_calibration.png': ('calibration', partial(draw_calibration, measured)),
        'sequence_story.png': ('a run with a jump and a rest', partial(draw_story, seed)),
        'sequence_jumps.png': ('jumps', partial(draw_jumps, measured.jumps)),
    }
    text = report(measured, seed, pictures(chosen.results, drawn))
    return publish(chosen.results, 'sequence', 'Windows in sequence', text)


if __name__ == '__main__':
    main()
