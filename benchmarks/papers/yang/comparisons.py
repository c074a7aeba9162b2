"""Comparisons of samples of errors: ratios of medians with intervals, and ranks of printed runs."""

from collections.abc import Iterable, Mapping, Sequence

import numpy as np
from scipy.stats import chi2

from benchmarks.intervals import ratio_interval
from benchmarks.papers.claims import Ratio
from benchmarks.papers.yang.reference import Cell, printed_errors
from benchmarks.papers.yang.run import PAPER, Errors
from benchmarks.papers.yang.starts import score
from obs_ros.core.typing import Array

LAST_DIGIT = 5e-7  # of the printed values: errors of 0 are at most half of it


def ratio(above: Iterable[float], below: Iterable[float]) -> Ratio:
    """Compare two samples."""
    return overall([np.array([*above])], [np.array([*below])])


def overall(above: Sequence[Array], below: Sequence[Array]) -> Ratio:
    """Compare samples pair by pair, and take the geometric mean of the ratios."""
    return Ratio(*ratio_interval(above, below))


def errors_ratio(errors: Errors, above: Cell, below: Cell) -> Ratio:
    """Compare the paper's search in two cells by the geometric means of its four errors."""
    return ratio(*(score(errors[cell, PAPER]) for cell in (above, below)))


def rank(errors: Errors, cell: Cell) -> int:
    """Return how many seeds have a geometric mean of the errors as small as the printed run's."""
    printed = score(np.maximum(printed_errors(cell), LAST_DIGIT))
    return int(np.count_nonzero(score(errors[cell, PAPER]) <= printed))


def combined_p(errors: Errors, cells: Sequence[Cell]) -> float:
    """Return the probability of ranks as low as those of the printed runs, if they are like ours.

    By Fisher's method over the cells, of p = (1 + rank) / (1 + seeds).
    """
    seeds = len(errors[cells[0], PAPER])
    p = np.array([(1 + rank(errors, cell)) / (1 + seeds) for cell in cells])
    return float(chi2.sf(-2.0 * np.log(p).sum(), 2 * p.size))


def as_good(errors: Errors, cell: Cell) -> tuple[int, Array]:
    """Return how many seeds have errors as small as printed: all four at once, and each (4,)."""
    below = errors[cell, PAPER] <= np.maximum(printed_errors(cell), LAST_DIGIT)
    return int(below.all(axis=1).sum()), np.count_nonzero(below, axis=0)


def listed(found: Mapping[str, object]) -> str:
    """Return named figures as text."""
    return '; '.join(f'{name}: {own}' for name, own in found.items())


def counted(found: Iterable[Ratio]) -> str:
    """Return how many ratios are on either side of 1 beyond doubt."""
    words = [own.word for own in found]
    return (
        ', '.join(
            f'{word} in {words.count(word)}' for word in ('smaller', 'larger', 'no difference')
        )
        + f' of {len(words)}'
    )
