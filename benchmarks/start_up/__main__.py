"""Time from the start of a new process to its first estimate, with a cold and a warm kernel cache.

Cold: an empty cache folder, as after installation or with a new model; Python's own byte code is
there. Warm: the kernels that an earlier process left.
"""

from collections.abc import Mapping, Sequence

from benchmarks.report import publish
from benchmarks.runner import options
from benchmarks.start_up.report import report
from benchmarks.start_up.run import Start, starts_of


def main(arguments: list[str] | None = None) -> Mapping[str, Sequence[Start]]:
    """Measure, print, and write the report."""
    parser = options(__doc__)
    parser.add_argument('--cold', type=int, default=3, help='starts with an empty cache')
    parser.add_argument('--warm', type=int, default=5, help='starts with a filled cache')
    chosen = parser.parse_args(arguments)
    starts = starts_of(chosen.cold, chosen.warm)
    publish(chosen.results, 'start_up', 'First estimate of a new process', report(starts))
    return starts


if __name__ == '__main__':
    main()
