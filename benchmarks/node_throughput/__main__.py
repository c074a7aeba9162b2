"""Messages lost by the estimator node while it solves: two streams from another process.

A run of the plant is sampled ahead and published at the rate asked for, `output` and `input` apart;
the node's own /diagnostics tell what arrived. Three tanks at 1 kHz for the sliding window, which
solves in a thread; a linear plant at 500 Hz for the genetic adaptive state estimator (N 200, W 50,
g_t 10), which breeds 5000 generations a second in the callback. Shares are of one core.
"""

from collections.abc import Mapping

from benchmarks.node_throughput.report import report
from benchmarks.node_throughput.run import CASES, measured
from benchmarks.report import publish
from benchmarks.runner import options


def main(arguments: list[str] | None = None) -> Mapping[str, Mapping[str, str]]:
    """Measure, print, and write the report; return the last figures by observer."""
    parser = options(__doc__)
    parser.add_argument('--seconds', type=int, default=30, help='length of each run')
    parser.add_argument('--domain', type=int, default=87, help='ROS domain id')
    chosen = parser.parse_args(arguments)
    found = [measured(case, chosen.seconds, chosen.domain) for case in CASES]
    text = '\n\n'.join(map(report, CASES, found))
    publish(chosen.results, 'node_throughput', 'Messages into the node', text)
    return {case.observer: one.figures for case, one in zip(CASES, found, strict=True)}


if __name__ == '__main__':
    main()
