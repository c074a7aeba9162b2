"""Time of a new process that makes one estimate, beside one that only imports NumPy and the like.

Cold: an empty cache folder, as after installation; Python's own byte code is there. Warm: the
kernels that an earlier process left.
"""

from collections.abc import Mapping, Sequence

from benchmarks.report import publish
from benchmarks.runner import options
from benchmarks.start_up.report import report
from benchmarks.start_up.run import Start, starts_of


def main(arguments: list[str] | None = None) -> Mapping[str, Sequence[Start]]:
    """Measure, print, and write the report."""
    parser = options(__doc__)
    parser.add_argument('--rounds', type=int, default=9, help='starts of each kind')
    chosen = parser.parse_args(arguments)
    starts = starts_of(chosen.rounds)
    publish(chosen.results, 'start_up', 'First estimate of a new process', report(starts))
    return starts


if __name__ == '__main__':
    main()
