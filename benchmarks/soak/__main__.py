"""A long run of the estimator node, accelerated: memory that stays flat, and no sample lost.

A three-tank run is published far faster than it was sampled, windows close one after the other,
and between them the state is predicted at every output.
"""

from benchmarks.live import Live
from benchmarks.report import publish
from benchmarks.runner import options
from benchmarks.soak.report import report
from benchmarks.soak.run import Soak, soaked


def main(arguments: list[str] | None = None) -> Soak:
    """Measure, print, and write the report."""
    parser = options(__doc__)
    parser.add_argument('--messages', type=int, default=1_020_000, help='in both streams together')
    parser.add_argument('--rate', type=int, default=1700, help='messages per s of wall time')
    parser.add_argument('--window', type=float, default=100.0, help='s of plant time')
    parser.add_argument('--domain', type=int, default=89, help='ROS domain id')
    chosen = parser.parse_args(arguments)
    live = Live(chosen.domain, f'window.duration:={chosen.window}')
    found = soaked(live, chosen.messages // 2, chosen.rate / 2)
    title = f'{2 * found.sent} messages through the estimator in {found.wall:.0f} s'
    publish(chosen.results, 'soak', title, report(found))
    return found


if __name__ == '__main__':
    main()
