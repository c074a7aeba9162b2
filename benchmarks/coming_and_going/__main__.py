"""Time of the estimator from its start to its first subscription, and from Ctrl-C to its exit.

Each in a new process with the kernels cached; also the seconds of process time, which others on the
machine do not lengthen.
"""

from collections.abc import Sequence

from benchmarks.coming_and_going.report import report
from benchmarks.coming_and_going.run import Stay, stays_of
from benchmarks.live import use_domain
from benchmarks.report import publish
from benchmarks.runner import options


def main(arguments: list[str] | None = None) -> Sequence[Stay]:
    """Measure, print, and write the report."""
    parser = options(__doc__)
    parser.add_argument('--starts', type=int, default=10)
    parser.add_argument('--domain', type=int, default=91, help='ROS domain id')
    chosen = parser.parse_args(arguments)
    use_domain(chosen.domain)
    stays = stays_of(chosen.starts)
    publish(chosen.results, 'coming_and_going', 'Start and end of a node', report(stays))
    return stays


if __name__ == '__main__':
    main()
