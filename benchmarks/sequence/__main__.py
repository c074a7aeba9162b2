"""Windows in sequence: how far their intervals and alarms can be believed, and what they cost.

Random runs of the three tanks and of a first-order lag, solved window by window with what earlier
windows have taught, beside other ways to use it. All runs are simulated with steps a hundredth of
the samples' interval.
"""

from benchmarks.common import machine, options, publish
from benchmarks.sequence.pictures import draw_calibration, draw_jumps, draw_story
from benchmarks.sequence.plan import PER_CELL, carried_out, compile_all, plan, timed_scenes
from benchmarks.sequence.report import parts

TITLE = 'Windows in sequence'


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
    compile_all(chosen.seed)
    measured = carried_out(
        plan(chosen.windows, chosen.seed), timed_scenes(chosen.windows, chosen.seed)
    )
    chosen.results.mkdir(parents=True, exist_ok=True)
    draw_story(chosen.results / 'sequence_story.png', chosen.seed)
    draw_calibration(chosen.results / 'sequence_calibration.png', measured)
    draw_jumps(chosen.results / 'sequence_jumps.png', measured.jumps)
    told = parts(measured, chosen.seed)
    return publish(chosen.results, 'sequence', TITLE, told, machine())


if __name__ == '__main__':
    main()
