"""Random malformed messages, thousands of them: the estimator counts them all and lives on.

Names, sizes, values and stamps are drawn at random, mostly absurd; in the end a sound run follows,
and its estimate must be right.
"""

import random

from benchmarks.fuzz.report import report
from benchmarks.fuzz.run import Fuzzed, fuzzed
from benchmarks.live import Live
from benchmarks.report import publish
from benchmarks.runner import options


def main(arguments: list[str] | None = None) -> Fuzzed:
    """Measure, print, and write the report."""
    parser = options(__doc__)
    parser.add_argument('--messages', type=int, default=20_000)
    parser.add_argument('--seed', type=int, default=0)
    parser.add_argument('--domain', type=int, default=90, help='ROS domain id')
    chosen = parser.parse_args(arguments)
    live = Live(chosen.domain, 'window.duration:=20.0')
    found = fuzzed(live, chosen.messages, random.Random(chosen.seed))
    publish(chosen.results, 'fuzz', f'{found.sent} malformed messages', report(found))
    return found


if __name__ == '__main__':
    main()
