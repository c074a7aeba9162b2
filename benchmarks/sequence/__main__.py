"""Windows in sequence: their intervals and alarms held against the truth, and their cost.

Random runs of the three tanks and of a first-order lag, solved window by window with the arrival
cost of earlier windows, beside other ways to use them; all simulated with steps a hundredth of the
samples' interval. And jumps, and what is none, on plants that nobody has tuned to.
"""

import argparse
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path

from benchmarks.report import pictures, publish
from benchmarks.runner import options
from benchmarks.sequence.jumps_elsewhere import report as elsewhere
from benchmarks.sequence.jumps_elsewhere import run as jumps_elsewhere
from benchmarks.sequence.pictures import draw_calibration, draw_jumps, draw_story
from benchmarks.sequence.report import report
from benchmarks.sequence.run import PER_CELL, carried_out, compile_all, plan, timed_scenes


def tanks_and_lag(chosen: argparse.Namespace) -> str:
    """Solve, count, print, and write the report on tanks and lag."""
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


def on_other_plants(chosen: argparse.Namespace) -> str:
    """Solve, count, print, and write the report on the plants that nobody has tuned to."""
    runs, length = chosen.runs, jumps_elsewhere.WINDOWS
    planned = jumps_elsewhere.plan(runs, length, chosen.seed)
    measured = jumps_elsewhere.carried_out(planned, chosen.against)
    text = elsewhere.report(measured, runs, length, chosen.seed)
    title = 'Jumps on plants that nobody has tuned to'
    return publish(chosen.results, 'sequence_jumps_elsewhere', title, text)


PARTS: Mapping[str, Callable[[argparse.Namespace], str]] = {
    'tanks_and_lag': tanks_and_lag,
    'jumps_elsewhere': on_other_plants,
}


def main(arguments: list[str] | None = None) -> str:
    """Measure the parts that are chosen, and return their reports."""
    parser = options(__doc__, shared=True)
    parser.add_argument(
        '--windows',
        type=int,
        default=PER_CELL,
        help='in each clean cell, about; the other tables of tanks and lag in proportion',
    )
    parser.add_argument(
        '--runs',
        type=int,
        default=jumps_elsewhere.RUNS,
        help='in each clean cell of jumps elsewhere',
    )
    parser.add_argument('--seed', type=int, default=90_000, help='of the first run')
    parser.add_argument('--only', choices=PARTS, help='one part')
    parser.add_argument(
        '--against', type=Path, help='another source tree, which solves jumps elsewhere, too'
    )
    chosen = parser.parse_args(arguments)
    return '\n'.join(part(chosen) for name, part in PARTS.items() if chosen.only in (None, name))


if __name__ == '__main__':
    main()
