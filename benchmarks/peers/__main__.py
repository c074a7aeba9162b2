"""Our default search beside other ways to estimate the same windows to the same target.

Three tanks (1000 samples, 20 dB) and Lorenz (5 time units, 500 samples, 40 dB), six unknowns each.
A window is solved when the squares are within 0.1025 d sigma^2 of the best known optimum. Peers are
an optional extra (`make peers`); one that is missing is skipped by name. With --many, windows of 20
to 60 unknowns beside scipy's least squares and CasADi.
"""

from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any

from benchmarks.c_twin import c_step
from benchmarks.peers import many
from benchmarks.peers.pictures import draw_times
from benchmarks.peers.registry import OURS, PEERS
from benchmarks.peers.report import report
from benchmarks.peers.run import CASES, Measured, solved
from benchmarks.report import filled, pictures, publish, requirements, versions
from benchmarks.runner import options
from benchmarks.zoo import MANY_UNKNOWNS

PACKAGES = ('pygmo', 'pymoo', 'cma', 'casadi', 'do-mpc', 'filterpy')


def main(arguments: list[str] | None = None) -> list[Measured]:
    """Judge, measure, print, and write the report."""
    parser = options(__doc__, shared=True)
    parser.add_argument('--windows', type=int, default=10, help='per case')
    parser.add_argument('--slow-windows', type=int, default=3, help='per case, for slow peers')
    parser.add_argument('--seed', type=int, default=8000, help='of the first window')
    parser.add_argument('--starts', type=int, default=6, help='of the judge, beside the truth')
    parser.add_argument('--cap', type=float, default=60.0, help='process time per solve, in s')
    parser.add_argument('--many', action='store_true', help='windows of many unknowns')
    parser.add_argument('--peers', nargs='+', choices=[*PEERS], metavar='NAME')
    parser.add_argument(
        '--cases', nargs='+', choices=[*CASES, *MANY_UNKNOWNS], metavar='CASE',
        help=f'of {", ".join(CASES)}; with --many of {", ".join(MANY_UNKNOWNS)}',
    )  # fmt: skip
    chosen = parser.parse_args(arguments)
    asked = chosen.peers or (many.PEERS if chosen.many else [*PEERS])
    cases = chosen.cases or [*(MANY_UNKNOWNS if chosen.many else CASES)]
    missing = [name for name in asked if not PEERS[name].present]
    for name in missing:
        print(f'{name}: skipped, {PEERS[name].package} is not installed (make peers)')
    present = [name for name in dict.fromkeys([OURS, *asked]) if name not in missing]
    seeds = range(chosen.seed, chosen.seed + chosen.windows)
    slow = seeds[: chosen.slow_windows]
    results = solved(cases, present, seeds, slow, chosen.starts, chosen.cap)
    facts = {'first': seeds[0], 'last': seeds[-1], 'cap': chosen.cap}
    if chosen.many:
        report_on_many(results, missing, facts, chosen.results)
    else:
        report_on_few(results, missing, facts, chosen.results)
    return results


def report_on_few(
    results: list[Measured], missing: list[str], facts: Mapping[str, Any], folder: Path
) -> None:
    """Write the report on windows of six unknowns."""
    drawn = {'peers.png': ('median process time by peer', partial(draw_times, results))}
    parts = {**report(results, missing), 'pictures': pictures(folder, drawn)}
    text = filled('peers/report', **facts, **parts)
    title = 'Peers: the same windows to the same target'
    publish(folder, 'peers', title, text, *versions(PACKAGES))


def report_on_many(
    results: list[Measured], missing: list[str], facts: Mapping[str, Any], folder: Path
) -> None:
    """Write the report on windows of many unknowns."""
    step = c_step()()
    asked = requirements(many.acceptance(results, step))
    parts = report(results, missing)
    text = filled('peers/many', **facts, **parts, acceptance=asked, step=1e9 * step)
    publish(folder, 'peers_many', 'Peers: many unknowns', text, *versions(PACKAGES))


if __name__ == '__main__':
    main()
