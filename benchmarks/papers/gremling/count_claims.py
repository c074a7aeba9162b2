"""The claims of Gremling & Passino 2000 on what a generation counts, judged."""

import numpy as np

from benchmarks.papers.claims import Claim, every, verdict, within
from benchmarks.papers.gremling.counts import DIGITS, ELITE, MUTATION, RANGES, N, W
from benchmarks.papers.gremling.run import Figures
from benchmarks.papers.gremling.scores import intervals, mean_text

NEAR = 0.01  # of a printed mean


def operations(figures: Figures) -> Claim:
    """Judge eq. 6 by the operations of a literal evaluation."""
    printed = 2 * N * (W + 1), N * (W + 2)
    criterion, total = (
        (each['additions'], each['multiplications']) for each in figures.operations
    )  # fmt: skip
    return Claim(
        'Eq. 6', f'a generation takes {printed[0]} additions, {printed[1]} multiplications in all',
        'operations counted, N 200, W 50, third order',
        f'{total[0]}, {total[1]} with the steps of the model (eq. 18), '
        f'{criterion[0]}, {criterion[1]} without',
        verdict(total == printed), 'the same',
    )  # fmt: skip


def whole_draws(figures: Figures) -> Claim:
    """Judge eqs. 7 and 8: random integers of parents, sites and alleles."""
    traits, genes, children = len(RANGES), len(RANGES) * DIGITS, N - ELITE
    expected = (traits / 2 + MUTATION * genes + 1) * children
    low, high = (traits / 2 + 1) * children, (traits / 2 + genes + 1) * children
    drawn = np.array([
        [each['parents'] + each['sites'] + each['alleles']] for each in figures.draws
    ], float)  # fmt: skip
    inside = bool((drawn >= low).all() and (drawn <= high).all())
    near = expected * (1.0 - NEAR), expected * (1.0 + NEAR)
    return Claim(
        'Eqs. 7, 8', f'random integers of a generation: {low:.0f} to {high:.0f}, '
        f'{expected:.0f} in the mean',
        f'{len(drawn)} generations counted; mean within {100.0 * NEAR:g} %',
        f'{drawn.min():.0f} to {drawn.max():.0f}, mean {mean_text(drawn, ".1f")}',
        every([verdict(inside), *(within(ends, near) for ends in intervals(drawn))]), 'the same',
    )  # fmt: skip


def real_draws(figures: Figures) -> Claim:
    """Judge eq. 9: random floating-point numbers."""
    most = len(RANGES) * (N - ELITE)
    replaced = [each['traits out of range'] for each in figures.draws]
    tests = [each['tests of mutation'] for each in figures.draws]
    totals = [sum(pair) for pair in zip(replaced, tests, strict=True)]
    return Claim(
        'Eq. 9', f'random floating-point numbers of a generation: 0 to {most}',
        f'{len(totals)} generations counted',
        f'{min(totals)} to {max(totals)}: {min(tests)} test whether genes mutate, '
        f'{min(replaced)} to {max(replaced)} replace traits',
        verdict(max(totals) <= most), 'one draw tests a gene and is its allele',
    )  # fmt: skip
