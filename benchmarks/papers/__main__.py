"""The source papers, audited: what each claims, how that was judged, and our default beside it.

Afterwards, or when it is stopped, the tables in docs/ that come from the committed results are
written anew, and the figures in their sentences.
"""

import signal
import sys

from benchmarks.documents import RESULTS, refresh
from benchmarks.papers.paper import load_paper, papers, reported
from benchmarks.runner import options

SEEDS = 200
STOPPED = 130  # exit code after Ctrl-C, as shells have it


def main(arguments: list[str] | None = None) -> None:
    """Measure the papers that are asked for, and write a report of each.

    One that is stopped or fails tells which reports are written; raises SystemExit after Ctrl-C.
    """
    parser = options(__doc__, shared=True)
    parser.add_argument('paper', nargs='?', choices=papers(), help='only this one')
    parser.add_argument('--seeds', type=int, default=SEEDS, help='runs for each rate')
    parser.add_argument('--documents', action='store_true', help='only write the tables in docs/')
    chosen = parser.parse_args(arguments)
    names = [] if chosen.documents else [chosen.paper] if chosen.paper else papers()
    written: list[str] = []
    try:
        for name in names:
            reported(name, chosen.seeds, chosen.results)
            written.append(name)
    except KeyboardInterrupt:
        raise SystemExit(STOPPED) from None
    finally:
        if left := names[len(written) :]:
            told = ', '.join(written) or 'none'
            print(f'reports written: {told}; not written: {", ".join(left)}', file=sys.stderr)
        if chosen.results == RESULTS:
            refresh([quote for name in papers() for quote in load_paper(name).quotes])


if __name__ == '__main__':
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # tells what is done, as Ctrl-C
    main()
