"""Observers of the heat exchanger's flows: Zhang et al. 2020, beside the claims of the paper.

Settling without noise, errors with noise over many seeds, and which valve the residuals name.
"""

from functools import partial

from benchmarks.interconnected.pictures import draw_flows
from benchmarks.interconnected.report import report
from benchmarks.interconnected.run import runs_of
from benchmarks.interconnected.windows import windows_of
from benchmarks.report import pictures, publish
from benchmarks.runner import options


def main(arguments: list[str] | None = None) -> str:
    """Run, print, and write the report with its picture; return the text."""
    parser = options(__doc__, shared=True)
    parser.add_argument('--seeds', type=int, default=10, help='noises per contestant and case')
    parser.add_argument('--first-seed', type=int, default=100, help='of the noises')
    given = parser.parse_args(arguments)
    seeds = range(given.first_seed, given.first_seed + given.seeds)
    windows = windows_of(seeds)
    flows = ('flows in the three cases', partial(draw_flows, given.first_seed))
    drawn = pictures(given.results, {'interconnected_flows.png': flows})
    text = report(*runs_of(seeds), windows, given.seeds, drawn)
    title = 'Observers of unmeasured flows: heat exchanger with two valves'
    return publish(given.results, 'interconnected', title, text)


if __name__ == '__main__':
    main()
