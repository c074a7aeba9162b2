"""Time of three-tank windows, warm and cold, beside what their rollouts take in C, in one run.

The limit of a window is the number of candidate-steps that it asked for, times what one takes in C.
Warm windows come in sequence, as in the node.
"""

from pathlib import Path

from benchmarks.fast_windows.report import report
from benchmarks.fast_windows.run import Row, beside, rows_of
from benchmarks.report import publish
from benchmarks.runner import options

QUICK = {'sequences': 1, 'windows': 4}


def main(arguments: list[str] | None = None) -> list[Row]:
    """Measure, print, and write the report."""
    parser = options(__doc__)
    parser.add_argument('--sequences', type=int, default=6, help='of each kind')
    parser.add_argument('--windows', type=int, default=12, help='of each sequence')
    parser.add_argument('--seed', type=int, default=180_000, help='of the first sequence')
    parser.add_argument('--against', type=Path, help='another source tree, to compare times with')
    parser.add_argument('--quick', action='store_true', help=f'{QUICK}, to see that it works')
    chosen = parser.parse_args(arguments)
    if chosen.quick:
        vars(chosen).update(QUICK)
    seeds = range(chosen.seed, chosen.seed + chosen.sequences)
    rows = rows_of(seeds, chosen.windows)
    pairs = beside(chosen.against, seeds, chosen.windows) if chosen.against else {}
    text = report(rows, pairs, chosen.windows)
    publish(chosen.results, 'fast_windows', 'Windows beside their rollouts', text)
    return rows


if __name__ == '__main__':
    main()
