"""H-infinity adaptive observers of a tyre's stiffness: Alvarado-Méndez et al. 2024, and beyond.

Errors with noise over many seeds on several roads, beside the claims of the paper.
"""

from functools import partial

from benchmarks.h_infinity.pictures import draw_stiffness
from benchmarks.h_infinity.report import report
from benchmarks.h_infinity.run import runs_of
from benchmarks.report import pictures, publish
from benchmarks.runner import options


def main(arguments: list[str] | None = None) -> str:
    """Run, print, and write the report with its picture; return the text."""
    parser = options(__doc__, shared=True)
    parser.add_argument('--seeds', type=int, default=10, help='noises per contestant and case')
    parser.add_argument('--long-seeds', type=int, default=3, help='noises of the runs of 65 s')
    parser.add_argument('--first-seed', type=int, default=100, help='of the noises')
    given = parser.parse_args(arguments)
    first = given.first_seed
    seeds, long_seeds = range(first, first + given.seeds), range(first, first + given.long_seeds)
    drawn = {'h_infinity_kt.png': ('kt over time', partial(draw_stiffness, first))}
    shown = pictures(given.results, drawn)
    text = report(*runs_of(seeds, long_seeds), given.seeds, given.long_seeds, shown)
    title = 'H-infinity adaptive observers: the stiffness of a tyre'
    return publish(given.results, 'h_infinity', title, text)


if __name__ == '__main__':
    main()
