"""The claims of Yang, Li & Dahhou 2020, in the order of the paper."""

from benchmarks.papers.claims import Claim
from benchmarks.papers.yang import algorithm_claims as algorithm
from benchmarks.papers.yang import problem_claims as problem
from benchmarks.papers.yang import table_claims as tables
from benchmarks.papers.yang.run import Figures


def claims(figures: Figures) -> list[Claim]:
    """Return all claims, judged."""
    return [
        problem.real_time(figures),
        problem.lipschitz(),
        algorithm.chaos(figures),
        algorithm.theorem(figures),
        algorithm.never_rises(figures),
        problem.euclidean(),
        algorithm.deviation(),
        algorithm.measured_levels(figures),
        algorithm.inherited(figures),
        algorithm.smaller(figures),
        tables.noise_free_parameters(figures),
        tables.noise_free_state(figures),
        tables.distance_to_zero(figures),
        tables.correlation_and_noise(figures),
        tables.higher_snr(figures),
        tables.euclidean_better(figures),
        tables.printed_table(figures, 'ft1', 1),
        tables.printed_table(figures, 'ft2', 2),
        tables.true_levels(),
        tables.reference_power(),
        tables.on_the_whole(figures),
    ]
