"""The claims of Yang, Li & Dahhou 2020 on the algorithm (section 4), judged by the figures."""

import numpy as np

from benchmarks.papers.claims import (
    AS_WELL,
    Claim,
    Ratio,
    Verdict,
    as_well,
    every,
    never,
    share,
    verdict,
)
from benchmarks.papers.yang.comparisons import listed, ratio
from benchmarks.papers.yang.run import DEFAULT, FIRST_SAMPLE, PAPER, Figures, scenario_of
from benchmarks.papers.yang.sequence import COLD, LATER, SMALL, UNCHANGED, WARM, scores
from benchmarks.papers.yang.starts import CUBIC, UNIFORM, errors_from
from benchmarks.papers.yang.starts import PAPER as PAPERS_SEARCH
from benchmarks.tanks import PAPER_WINDOWS, paper_levels


def chaos(figures: Figures) -> Claim:
    """Judge the cubic map by the errors after the paper's search, and by Lorenz's valleys."""
    found = {
        window: ratio(
            *(errors_from(figures.starts, PAPERS_SEARCH, kind, window) for kind in (CUBIC, UNIFORM))
        )
        for window in PAPER_WINDOWS
    }
    return Claim(
        '4.1',
        'a chaotic sequence in place of a random one improves DE',
        f'errors at 40 dB from the cubic map over those from uniform points; '
        f'{figures.seeds} seeds each; holds if smaller in every window',
        listed(found),
        every(own.smaller for own in found.values()),
        'random starts do as well: table of starts',
    )


def theorem(figures: Figures) -> Claim:
    """Judge global convergence on a plant with false minima, and by longer runs on the tanks."""
    runs = figures.collapses[CUBIC]
    lost = sum(run.lost for run in runs)
    return Claim(
        'Theorem 1',
        'chaotic DE converges to x0 with the iterations, from any start, on observable plants',
        "Lorenz's plant, no noise: runs whose whole population has shrunk below 1e-6 boxes away "
        'from the truth, so that none can follow; one refutes it',
        share(lost, len(runs)),
        never(lost, len(runs)),
        'several rounds, each tested against the noise; an outcome says when none fits',
    )


def never_rises(figures: Figures) -> Claim:
    """Judge eq. 11 by every generation of the same runs."""
    runs = [run for own in figures.collapses.values() for run in own]
    rises, count = sum(run.rises for run in runs), sum(run.generations for run in runs)
    return Claim(
        'eq. 11',
        'the least deviation never grows with the iterations',
        f'generations in which it grew, {len(runs)} runs of the theorem',
        f'{rises} of {count}',
        verdict(rises == 0),
    )


def deviation() -> Claim:
    """Judge eq. 14 by an output that is another one scaled and shifted."""
    y = paper_levels('T2')[:, 0]
    other = 0.5 * y + 10.0
    correlation = float(np.corrcoef(y, other)[0, 1])
    apart = float(np.abs(y - other).max())
    return Claim(
        '4.2.2, eq. 14',
        'the correlation is a deviation: 0 only where both outputs are the same',
        'h1 of T2 beside 0.5 h1 + 10 cm',
        f'deviation {abs(1.0 - correlation):.0e}, {apart:.1f} cm apart',
        verdict(abs(1.0 - correlation) > 1e-9),
        'least squares, 0 only where all residuals are',
    )


def measured_levels(figures: Figures) -> Claim:
    """Judge first samples taken for initial levels by h3, where there is noise to take."""
    found = {
        cell: ratio(*(figures.errors[cell, way][:, 3] for way in (FIRST_SAMPLE, PAPER)))
        for cell, way in figures.solves
        if way == FIRST_SAMPLE
    }
    h3 = {cell: ratio(*(figures.errors[cell, way][:, 3] for way in (DEFAULT, FIRST_SAMPLE)))
          for cell in found}  # fmt: skip
    return Claim(
        '4.3',
        'measured states need no estimate: their measurements are used in the model',
        'errors of h3 with the first sample over those with the true levels, 0 and -20 dB; '
        f'holds if nowhere above {AS_WELL:g}',
        listed({scenario_of(cell): own for cell, own in found.items()}),
        every(as_well(own.ends) for own in found.values()),
        'all levels estimated; its h3 over that with the first sample: '
        + listed({scenario_of(cell): own for cell, own in h3.items()}),
    )


def inherited(figures: Figures) -> Claim:
    """Judge the warm start by the windows after the first."""
    found = {name: sequence_ratio(figures, WARM, COLD, name) for name in LATER}
    if any(own.worse for own in found.values()):
        judged = Verdict.DOES_NOT_HOLD
    else:
        shown = any(own.better for own in found.values())
        judged = Verdict.HOLDS if shown else Verdict.NOT_SHOWN
    return Claim(
        '4.4.2',
        'an inherited individual accelerates the search in the next windows',
        f'errors at 40 dB after 85 generations, warm over cold, T1 to T3 and {UNCHANGED}; '
        f'{figures.seeds} sequences each; holds if smaller in one and larger in none',
        listed(found),
        judged,
        'warm start raced against fresh starts',
    )


def smaller(figures: Figures) -> Claim:
    """Judge a smaller population in the later windows."""
    found = {name: sequence_ratio(figures, SMALL, WARM, name) for name in LATER}
    return Claim(
        '4.4.2',
        'fewer individuals do in the windows after the first',
        f'errors, {SMALL} over {WARM}; holds if nowhere above {AS_WELL:g}',
        listed(found),
        every(as_well(own.ends) for own in found.values()),
    )


def sequence_ratio(figures: Figures, above: str, below: str, period: str) -> Ratio:
    """Compare two ways of going from window to window."""
    return ratio(*(scores(figures.sequences, way, period) for way in (above, below)))
