"""The claims of Yang, Li & Dahhou 2020, judged by the figures."""

import numpy as np

from benchmarks.papers.claims import Claim, share, verdict
from benchmarks.papers.yang.reference import Cell, references
from benchmarks.papers.yang.run import PAPER, Figures


def claims(figures: Figures) -> list[Claim]:
    """Return the claims in the order of the paper."""
    return [table_claim(figures, fitness, number) for fitness, number in (('ft1', 1), ('ft2', 2))]


def table_claim(figures: Figures, fitness: str, number: int) -> Claim:
    """Judge a table: each of its cells is a run as good as one of twenty at least."""
    own = [cell for cell in figures.cells if cell.fitness == fitness and np.isfinite(cell.snr_db)]
    hits = {cell: as_good(figures, cell) for cell in own}
    least = min(own, key=lambda cell: hits[cell])
    return Claim(
        f'Table {number}',
        'these errors are those of the algorithm',
        f'{figures.seeds} seeds: share with all four errors as small as printed',
        f'least {share(hits[least], figures.seeds)}, {least.window} at {least.snr_db:g} dB',
        verdict(all(count >= 0.05 * figures.seeds for count in hits.values())),
    )


def as_good(figures: Figures, cell: Cell) -> int:
    """Return how many seeds have all four errors as small as the printed run."""
    return int((figures.errors[cell, PAPER] <= references()[cell].run).all(axis=1).sum())
