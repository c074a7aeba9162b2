"""Random windows of the zoo: the success, time and false accepts of every search.

The default search against its rivals, to the end and under deadlines, and the worth of its rules of
acceptance. A window is solved when the squares, outputs weighted by their true noise, are
within 0.1025 d sigma^2 of the least that anyone has found: an independent judge (scipy from the
truth, about it and elsewhere) or any search of this run.
"""

from functools import partial

from benchmarks.report import pictures, publish
from benchmarks.runner import monte_carlo, options
from benchmarks.search.contest import contested
from benchmarks.search.deadline import answered
from benchmarks.search.pictures import draw_deadlines, draw_success
from benchmarks.search.report import HARD, report
from benchmarks.zoo import CASES
from obs_ros.integration.backends import kernels_for

QUICK_WINDOWS = 4
DEADLINE_WINDOWS = 10  # of every hard case


def main(arguments: list[str] | None = None) -> str:
    """Solve, judge, print, and write the report."""
    parser = options(__doc__, shared=True)
    parser.add_argument('--windows', type=int, default=50, help='random windows of each case')
    parser.add_argument('--cases', nargs='+', default=list(CASES), choices=list(CASES))
    parser.add_argument('--seed', type=int, default=70_000, help='of the first window')
    parser.add_argument('--quick', action='store_true', help=f'{QUICK_WINDOWS} windows of each')
    chosen = parser.parse_args(arguments)
    windows = QUICK_WINDOWS if chosen.quick else chosen.windows
    for name in chosen.cases:
        _ = kernels_for(CASES[name].model)  # compiled here, once, and cached for the workers
    seeds = range(chosen.seed, chosen.seed + windows)
    tasks = {name: [(name, seed) for seed in seeds] for name in chosen.cases}
    verdicts = monte_carlo(contested, tasks, 'solve and judge')
    hard = [name for name in HARD if name in chosen.cases]
    answers = [answered(name, seed) for name in hard for seed in seeds[:DEADLINE_WINDOWS]]
    drawn = {
        'search_success.png': ('success', partial(draw_success, verdicts)),
        'search_deadlines.png': ('deadlines', partial(draw_deadlines, verdicts)),
    }
    text = report(verdicts, answers, seeds, pictures(chosen.results, drawn))
    return publish(chosen.results, 'search', 'Searches on random windows of the zoo', text)


if __name__ == '__main__':
    main()
