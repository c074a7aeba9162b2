"""Coverage of windows whose states are pushed about, with process noise off and found."""

from benchmarks.process_noise.report import acceptance, results
from benchmarks.process_noise.run import WALKS, solved
from benchmarks.report import filled, publish, requirements
from benchmarks.runner import monte_carlo, options


def main(arguments: list[str] | None = None) -> str:
    """Simulate, solve, print, and write the report."""
    parser = options(__doc__)
    parser.add_argument('--windows', type=int, default=400, help='of each plant and walk')
    parser.add_argument('--seed', type=int, default=70000, help='of the first window')
    chosen = parser.parse_args(arguments)
    seeds = range(chosen.seed, chosen.seed + chosen.windows)
    cells = {
        (name, walk, mode): [(name, walk, mode, seed) for seed in seeds]
        for name, walks in WALKS.items()
        for walk in walks
        for mode in ('off', 'auto')
    }
    found = monte_carlo(solved, cells, 'windows', chunk=5)
    text = filled(
        'process_noise/report',
        windows=chosen.windows,
        seed=chosen.seed,
        results=results(found),
        acceptance=requirements(acceptance(found)),
    )
    return publish(chosen.results, 'process_noise', 'Windows with process noise', text)


if __name__ == '__main__':
    main()
