"""Windows that their model does not fit: what sequences of them publish, and what they cost."""

from benchmarks.mismatch.cost import SEEDS, cost, runs
from benchmarks.mismatch.report import acceptance, costs_table, sequences_table
from benchmarks.mismatch.run import MODES, SCENES, SPACINGS, WINDOWS, followed
from benchmarks.report import filled, publish, requirements
from benchmarks.runner import monte_carlo, options


def main(arguments: list[str] | None = None) -> str:
    """Simulate, solve, print, and write the report."""
    parser = options(__doc__, shared=True)
    parser.add_argument('--seeds', type=int, default=20, help='runs of each kind of sequence')
    parser.add_argument('--windows', type=int, default=WINDOWS, help='of each run')
    parser.add_argument('--seed', type=int, default=80000, help='of the first run')
    chosen = parser.parse_args(arguments)
    seeds = range(chosen.seed, chosen.seed + chosen.seeds)
    sequences = monte_carlo(
        followed,
        {
            (scene, spacing, mode): [(scene, spacing, mode, seed, chosen.windows) for seed in seeds]
            for scene in SCENES
            for spacing in SPACINGS
            for mode in MODES
        },
        'sequences',
    )
    costs = monte_carlo(cost, runs(chosen.seed), 'costs')
    text = filled(
        'mismatch/report',
        seeds=chosen.seeds,
        seed=chosen.seed,
        windows=chosen.windows,
        sequences=sequences_table(sequences),
        cost_seeds=SEEDS,
        costs=costs_table(costs),
        acceptance=requirements(acceptance(sequences, costs)),
    )
    return publish(chosen.results, 'mismatch', 'Windows that no model fits', text)


if __name__ == '__main__':
    main()
