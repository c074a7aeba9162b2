"""Yang, Li & Dahhou 2020: adaptive observer by chaotic differential evolution, three tanks.

Paper mode: chaotic DE, rand/1/bin, cubic map, 25 individuals, 85 generations; p1, p2, p3 and the
initial h3 unknown, the initial h1 and h2 given. Beside it the default search and the Cramér-Rao
bound.
"""

from functools import partial

from benchmarks.papers.paper import Drawn, Paper
from benchmarks.papers.yang.claims import claims
from benchmarks.papers.yang.pictures import draw_convergence, draw_errors
from benchmarks.papers.yang.report import report
from benchmarks.papers.yang.run import Figures, measure


def pictures(figures: Figures) -> Drawn:
    """Return the pictures by file name."""
    return {
        'papers_yang_errors.png': (
            'error against SNR', partial(draw_errors, figures.errors, figures.cells)
        ),
        'papers_yang_convergence.png': ('convergence', partial(draw_convergence, figures.followed)),
    }  # fmt: skip


PAPER = Paper(
    title='Yang, Li & Dahhou 2020: adaptive observer by chaotic differential evolution',
    measure=measure,
    claims=claims,
    report=report,
    pictures=pictures,
)
