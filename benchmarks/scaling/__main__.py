"""Growth of the cost of a solve: samples, unknowns, lanes, output rate, plants in one process.

Cold starts with the defaults; process time in one process. Where a growth is worse than linear the
columns tell why: candidate-steps (the work), calls of the kernels, ns per candidate-step, and the
share outside the kernels: Python, and the small linear algebra.
"""

from functools import partial

from benchmarks.report import pictures, publish
from benchmarks.runner import options
from benchmarks.scaling import run
from benchmarks.scaling.pictures import draw_scaling
from benchmarks.scaling.report import report


def main(arguments: list[str] | None = None) -> str:
    """Measure, print, and write the report."""
    parser = options(__doc__)
    parser.add_argument('--windows', type=int, default=15, help='random windows at every size')
    parser.add_argument('--seed', type=int, default=80_000, help='of the first window')
    parser.add_argument('--quick', action='store_true', help='3 windows, and less of everything')
    chosen = parser.parse_args(arguments)
    keep = 3 if chosen.quick else None  # of every list of sizes
    seeds = range(chosen.seed, chosen.seed + (3 if chosen.quick else chosen.windows))
    curves = [
        run.by_samples(run.SAMPLES[:keep], seeds),
        run.by_rate(run.PERIODS[:keep], seeds),
        run.by_tanks(run.TANKS[:keep], seeds),
        run.by_free(run.FREE[:keep], seeds),
        run.by_lanes(run.LANES[:keep]),
        run.by_plants(run.PLANTS[:keep], chosen.seed),
    ]
    drawn = {'scaling.png': ('growth', partial(draw_scaling, curves))}
    text = report(curves, seeds, pictures(chosen.results, drawn))
    return publish(chosen.results, 'scaling', 'How the cost grows', text)


if __name__ == '__main__':
    main()
