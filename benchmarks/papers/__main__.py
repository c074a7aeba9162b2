"""The source papers, audited: what each claims, how that was judged, and our default beside it.

Afterwards the tables in docs/ that come from the committed results are written anew.
"""

from benchmarks.documents import RESULTS, refresh
from benchmarks.papers.paper import papers, reported
from benchmarks.runner import options

SEEDS = 200


def main(arguments: list[str] | None = None) -> None:
    """Measure the papers that are asked for, and write a report of each."""
    parser = options(__doc__, shared=True)
    parser.add_argument('paper', nargs='?', choices=papers(), help='only this one')
    parser.add_argument('--seeds', type=int, default=SEEDS, help='runs for each rate')
    parser.add_argument('--documents', action='store_true', help='only write the tables in docs/')
    chosen = parser.parse_args(arguments)
    names = [chosen.paper] if chosen.paper else papers()
    for name in [] if chosen.documents else names:
        reported(name, chosen.seeds, chosen.results)
    if chosen.results == RESULTS:
        refresh()


if __name__ == '__main__':
    main()
