"""Our default search beside other ways to estimate the same windows to the same target.

Three tanks (1000 samples, 20 dB) and Lorenz (5 time units, 500 samples, 40 dB), six unknowns each.
A window is solved when the squares are within 0.1025 d sigma^2 of the best known optimum. Peers are
an optional extra (`make peers`); one that is missing is skipped by name.
"""

from functools import partial

from benchmarks.peers.pictures import draw_times
from benchmarks.peers.registry import OURS, PEERS
from benchmarks.peers.report import report
from benchmarks.peers.run import CASES, Measured, solved
from benchmarks.report import filled, pictures, publish, versions
from benchmarks.runner import options

PACKAGES = ('pygmo', 'pymoo', 'cma', 'casadi', 'do-mpc', 'filterpy')


def main(arguments: list[str] | None = None) -> list[Measured]:
    """Judge, measure, print, and write the report."""
    parser = options(__doc__, shared=True)
    parser.add_argument('--windows', type=int, default=10, help='per case')
    parser.add_argument('--slow-windows', type=int, default=3, help='per case, for slow peers')
    parser.add_argument('--seed', type=int, default=8000, help='of the first window')
    parser.add_argument('--starts', type=int, default=6, help='of the judge, beside the truth')
    parser.add_argument('--cap', type=float, default=60.0, help='process time per solve, in s')
    parser.add_argument('--peers', nargs='+', choices=[*PEERS], default=[*PEERS], metavar='NAME')
    parser.add_argument('--cases', nargs='+', choices=CASES, default=[*CASES], metavar='CASE')
    chosen = parser.parse_args(arguments)
    missing = [name for name in chosen.peers if not PEERS[name].present]
    for name in missing:
        print(f'{name}: skipped, {PEERS[name].package} is not installed (make peers)')
    present = [name for name in dict.fromkeys([OURS, *chosen.peers]) if name not in missing]
    seeds = range(chosen.seed, chosen.seed + chosen.windows)
    slow = seeds[: chosen.slow_windows]
    results = solved(chosen.cases, present, seeds, slow, chosen.starts, chosen.cap)
    drawn = {'peers.png': ('median process time by peer', partial(draw_times, results))}
    parts = {**report(results, missing), 'pictures': pictures(chosen.results, drawn)}
    text = filled('peers/report', first=seeds[0], last=seeds[-1], cap=chosen.cap, **parts)
    title = 'Peers: the same windows to the same target'
    publish(chosen.results, 'peers', title, text, *versions(PACKAGES))
    return results


if __name__ == '__main__':
    main()
