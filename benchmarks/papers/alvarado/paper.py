"""Alvarado-Méndez et al. 2024: H-infinity adaptive observer of a suspension's tyre stiffness.

The printed equations without noise, and with noise the package's observers beside each other on
several roads.
"""

from functools import partial

from benchmarks.papers.alvarado.claims import claims
from benchmarks.papers.alvarado.pictures import draw_stiffness
from benchmarks.papers.alvarado.report import report
from benchmarks.papers.alvarado.run import Figures, measure
from benchmarks.papers.paper import Drawn, Paper


def pictures(figures: Figures) -> Drawn:
    """Return the pictures by file name."""
    return {'papers_alvarado_kt.png': ('kt over time', partial(draw_stiffness, figures.first))}


PAPER = Paper(
    title="Alvarado-Méndez et al. 2024: H-infinity adaptive observer of a tyre's stiffness",
    measure=measure,
    claims=claims,
    report=report,
    pictures=pictures,
)
