"""Random three-tank windows: the success of the default search, and its cost.

Six unknowns, cold start. An independent least-squares search (benchmarks/judge.py) decides where
the optimum is; a window is solved when the sum of squares, both outputs weighted equally, is within
0.41 sigma^2 of it.
"""

from benchmarks.report import publish
from benchmarks.runner import options
from benchmarks.windows.report import report, section
from benchmarks.windows.run import FULL_WINDOW, judge_all, solve_all, warm_up


def main(arguments: list[str] | None = None) -> str:
    """Solve, judge, print, and write the report."""
    parser = options(__doc__, shared=True)
    parser.add_argument('--windows', type=int, default=50, help='number of random windows')
    parser.add_argument('--samples', type=int, default=FULL_WINDOW, help='per window, 1 s apart')
    parser.add_argument('--snr', type=float, nargs='+', default=[20.0], help='in dB')
    parser.add_argument('--seed', type=int, default=1000, help='of the first window')
    parser.add_argument('--starts', type=int, default=6, help='of the judge, beside the truth')
    chosen = parser.parse_args(arguments)
    seeds = range(chosen.seed, chosen.seed + chosen.windows)
    warm_up(chosen.samples)
    sections = []
    for snr in chosen.snr:
        solved = solve_all(seeds, chosen.samples, snr)
        verdicts = judge_all(solved, seeds, chosen.samples, snr, chosen.starts)
        sections.append(section(snr, chosen.samples, seeds, solved, verdicts))
    text = report(sections, seeds, chosen.samples, chosen.starts)
    title = f'Random three-tank windows of {chosen.samples} samples'
    return publish(chosen.results, f'windows_{chosen.samples}', title, text)


if __name__ == '__main__':
    main()
