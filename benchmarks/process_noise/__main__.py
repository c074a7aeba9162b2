"""Coverage and errors of windows whose states are pushed about, with process noise off and found.

The reference is maximum likelihood from the truth, by a Kalman filter of the benchmark's own.
"""

from benchmarks.process_noise.plants import PLANTS, WALKS
from benchmarks.process_noise.report import acceptance, results
from benchmarks.process_noise.run import solved
from benchmarks.report import filled, publish, requirements
from benchmarks.runner import monte_carlo, options


def main(arguments: list[str] | None = None) -> str:
    """Simulate, solve, print, and write the report."""
    parser = options(__doc__, shared=True)
    parser.add_argument('--windows', type=int, default=400, help='of each plant and walk')
    parser.add_argument('--seed', type=int, default=70000, help='of the first window')
    parser.add_argument('--referred', type=int, default=100, help='windows that the reference has')
    parser.add_argument('--plants', nargs='+', default=list(PLANTS), choices=PLANTS)
    chosen = parser.parse_args(arguments)
    cells = {
        (name, walk): [
            (name, walk, chosen.seed + i, i < chosen.referred) for i in range(chosen.windows)
        ]
        for name in chosen.plants
        for walk in WALKS[name]
    }
    found = monte_carlo(solved, cells, 'windows', chunk=5)
    text = filled(
        'process_noise/report',
        windows=chosen.windows,
        seed=chosen.seed,
        referred=min(chosen.referred, chosen.windows),
        results=results(found),
        acceptance=requirements(acceptance(found)),
    )
    return publish(chosen.results, 'process_noise', 'Windows with process noise', text)


if __name__ == '__main__':
    main()
